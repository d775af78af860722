"""The result of a search: steps, findings, and what was refused."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.judge.judge import Judgement, Rejection
from ident.diagnosis.judge.paying_joints import own_joints
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.structure import Term

WIDTH = 3
"""Number of models that stay open, of candidates that are fitted in any case, of lines of one effect among them, of
peaks of a spectrum that are tried in turn, and of alternatives that are named: one that imitates another, the other,
and a third that contains it."""
Exclusion = Literal["collinear", "sign"]
"""collinear: other parameters reproduce its torque; sign: its coefficient would need an impossible sign."""


@dataclass(frozen=True, eq=False)
class SelectionStep:
    """One model on the way from the initial one to the last."""

    added: str | None
    model: FittedModel
    improvement: Improvement | None


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect of the last model, or one that may belong to it."""

    term: Term
    before: FittedModel
    """Without the effect, refitted."""
    after: FittedModel
    """With it."""
    judgement: Judgement
    """What the judge says of it beside the rest of the model."""
    alternatives: tuple[str, ...] = ()
    """Other effects that would explain these data equally well in its place, the closest first."""
    compared: int = 1
    """Number of models among which the held-out rows chose this effect; the interval allows for it."""

    @cached_property
    def improvement(self) -> Improvement:
        """On the held-out rows, by the effect."""
        return self.after.improvement_over(self.before, compared=self.compared, joints=own_joints(self.term))


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of a search."""

    steps: tuple[SelectionStep, ...]
    findings: tuple[Finding, ...]
    likely: tuple[Finding, ...] = ()
    """Effects for which the evidence speaks, but which the held-out rows lack the power to confirm."""
    rejected: Mapping[str, Rejection] = field(default_factory=dict)
    """All other effects that were tried, with the evidence beside the last model."""
    first_reductions: Mapping[str, float] = field(default_factory=dict)
    """Relative reduction of the loss that screening promises of each effect beside the first model."""
    last_reductions: Mapping[str, float] = field(default_factory=dict)
    """The same beside the last model."""

    def on(self, split: SplitData) -> "Selection":
        """The same models, judged on the rows of `split`."""
        steps = (replace(step, model=FittedModel(split, step.model.solution)) for step in self.steps)
        return replace(self, steps=tuple(steps))

    @property
    def model(self) -> FittedModel:
        """The last model."""
        return self.steps[-1].model
