"""The steps of a diagnosis: models on the way, what could be added to them, and what was found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ident.diagnosis.improvement import Improvement
from ident.diagnosis.noise_floor import NoiseFloor
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

Exclusion = Literal["imitated", "sign"]
"""imitated: other parameters make up all that it would change; sign: it would need one that it cannot have."""


@dataclass(frozen=True, eq=False)
class FittedModel:
    """A model on the way, with what it leaves."""

    solution: Solution
    residuals: tuple[Floats, ...]
    """(m, dof) of every recording."""

    @property
    def terms(self) -> tuple[Term, ...]:
        """Its effects."""
        return self.solution.composition.terms


@dataclass(frozen=True, eq=False)
class Extensions:
    """Beyond one model."""

    models: tuple[FittedModel, ...]
    """With one effect more, the best first."""
    excluded: Mapping[str, "Exclusion"]
    """Effects that could not be looked at any further, and why."""
    loss_reductions: Mapping[str, float]
    """What each effect would gain at first sight, as a share of the loss."""


@dataclass(frozen=True, eq=False)
class SelectionStep:
    """A step of the ladder."""

    added: str | None
    model: FittedModel
    improvement: Improvement | None


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect of the final model."""

    term: Term
    improvement: Improvement
    """What leaving it out would cost on held-out rows."""
    alternatives: tuple[str, ...]
    """Other effects that would explain these data as well in its place, the closest first."""
    residuals_without: tuple[Floats, ...]
    """(m, dof) what the final model leaves of each recording without this effect, refitted [N m]."""
    residuals_with: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class Selection:
    """All that was found."""

    steps: tuple[SelectionStep, ...]
    findings: tuple[Finding, ...]
    first_extensions: Extensions
    """What could have been added first."""
    last_extensions: Extensions
    """What could be added still."""
    noise_floor: NoiseFloor
    computed: tuple[Floats, ...]
    """(m, dof) torque of the final model on each recording [N m]."""
