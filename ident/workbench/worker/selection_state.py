"""State of the manual stepwise selection: recordings, current step_list, and steps that need no refit."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from ident.diagnosis.diagnosis import DiagnosisInputs
from ident.diagnosis.document import verdict
from ident.diagnosis.document.document import labels
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import judge
from ident.diagnosis.search.candidates import added_term
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import SelectionStep
from ident.workbench.worker.views import ModelSpec, StepView
from recordings.files import sha256

_MAX_KNOWN_STEPS = 16
"""Steps kept for undo and redo without a refit."""


@dataclass(frozen=True, eq=False)
class FittedStep:
    """A model, and what the page shows of the change that led to it."""

    model: FittedModel
    view: StepView


@dataclass(eq=False)
class SelectionState:
    """Recordings and the current list of steps."""

    files: tuple[Path, Path | None]
    inputs: DiagnosisInputs
    selector: Search
    steps: tuple[FittedStep, ...] = ()
    known_steps: dict[tuple[ModelSpec, ...], FittedStep] = field(default_factory=dict)
    """Steps by the specifications of the list of steps that leads to them."""

    @cached_property
    def digests(self) -> tuple[str, ...]:
        """Return the SHA-256 of the files."""
        return tuple(sha256(file) for file in self.files if file)

    @property
    def model(self) -> FittedModel:
        """Return the current model."""
        return self.steps[-1].model

    @property
    def specs(self) -> tuple[ModelSpec, ...]:
        """Return the specifications of all steps."""
        return tuple(step.view.spec for step in self.steps)

    def set_steps(self, *steps: FittedStep) -> None:
        """Make `steps` the current list of steps."""
        self.steps = steps
        for number, step in enumerate(steps, start=1):
            self.known_steps[self.specs[:number]] = step
        while len(self.known_steps) > max(_MAX_KNOWN_STEPS, len(steps)):
            del self.known_steps[next(iter(self.known_steps))]

    def push(self, label: str, added: str | None, model: FittedModel) -> None:
        """Append `model` as a step; `added`: name of the added effect, None for a removal."""
        step = SelectionStep(added, model, model.improvement_over(self.model))
        self.set_steps(*self.steps, fitted_step(label, step, self.model))


def fitted_steps(steps: Sequence[SelectionStep]) -> tuple[FittedStep, ...]:
    """Return the steps of a search with their labels."""
    names = labels([[term.name for term in step.model.terms] for step in steps])
    before = (None, *(step.model for step in steps[:-1]))
    return tuple(map(fitted_step, names, steps, before))


def fitted_step(label: str, step: SelectionStep, before: FittedModel | None) -> FittedStep:
    """Return the `step` from the model `before`, which is None for the first one, with its view."""
    model = step.model
    view = StepView(
        label=label,
        entry=verdict.step_entry(step.added, model),
        terms=tuple((term.name, tuple(joint + 1 for joint in term.joints)) for term in model.terms),
        x=tuple(model.solution.x.tolist()),
        improvement=step.improvement,
        refusal=_refusal(before, step) if before else "",
    )
    return FittedStep(model, view)


def _refusal(before: FittedModel, step: SelectionStep) -> str:
    """Why the judge does not accept what `step` adds to the model `before`; empty if it does, or nothing is added."""
    effect = added_term(before, step.model)
    if step.added is None or step.model.terms[effect].effect.mandatory:
        return ""
    return judge(before, step.model, effect).reason
