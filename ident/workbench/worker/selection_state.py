"""State of the manual stepwise selection: recordings, current step_list, and steps that need no refit."""

from dataclasses import dataclass, field
from pathlib import Path

from ident.diagnosis.diagnosis import DiagnosisInputs
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import SelectionStep
from ident.workbench.worker.views import ModelSpec

_MAX_KNOWN_STEPS = 16
"""Steps kept for undo and redo without a refit."""


@dataclass(frozen=True, eq=False)
class LabelledStep:
    """A step and the label of the change that led to it."""

    label: str
    step: SelectionStep

    @property
    def spec(self) -> ModelSpec:
        """Return the specification from which the model can be rebuilt."""
        terms = tuple((term.name, tuple(joint + 1 for joint in term.joints)) for term in self.step.model.terms)
        return self.label, terms, tuple(self.step.model.solution.x.tolist())


@dataclass(eq=False)
class SelectionState:
    """Recordings and the current list of steps."""

    files: tuple[Path, Path | None]
    inputs: DiagnosisInputs
    selector: Search
    steps: tuple[LabelledStep, ...] = ()
    known_steps: dict[tuple[ModelSpec, ...], LabelledStep] = field(default_factory=dict)
    """Steps by the specifications of the list of steps that leads to them."""
    diagnosed: FittedModel | None = None
    """Final model of the full diagnosis."""

    @property
    def model(self) -> FittedModel:
        """Return the current model."""
        return self.steps[-1].step.model

    @property
    def specs(self) -> tuple[ModelSpec, ...]:
        """Return the specifications of all steps."""
        return tuple(step.spec for step in self.steps)

    def set_steps(self, *steps: LabelledStep) -> None:
        """Make `steps` the current list of steps."""
        self.steps = steps
        for number, step in enumerate(steps, start=1):
            self.known_steps[self.specs[:number]] = step
        while len(self.known_steps) > max(_MAX_KNOWN_STEPS, len(steps)):
            del self.known_steps[next(iter(self.known_steps))]

    def push(self, label: str, added: str | None, model: FittedModel) -> None:
        """Append `model` as a step; `added`: name of the added effect, None for a removal."""
        self.set_steps(
            *self.steps,
            LabelledStep(label, SelectionStep(added, model, model.improvement_over(self.model))),
        )
