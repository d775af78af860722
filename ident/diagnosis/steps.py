"""Data of a stepwise selection: models, their extensions, steps and findings."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ident.diagnosis.improvement import Improvement
from ident.diagnosis.noise_floor import NoiseFloor
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

Exclusion = Literal["collinear", "sign"]
"""collinear: other parameters reproduce its torque; sign: its coefficient would need an impossible sign."""


@dataclass(frozen=True, eq=False)
class FittedModel:
    """A fitted model with its residuals."""

    solution: Solution
    residuals: tuple[Floats, ...]
    """(m, dof) of every recording."""

    @property
    def terms(self) -> tuple[Term, ...]:
        """Its effects."""
        return self.solution.structure.terms


@dataclass(frozen=True, eq=False)
class Extensions:
    """Models that extend one model by one effect."""

    models: tuple[FittedModel, ...]
    """The best first."""
    excluded: Mapping[str, "Exclusion"]
    """Effects that were excluded by screening, with the reason."""
    loss_reductions: Mapping[str, float]
    """Relative reduction of the loss by each effect, as estimated by screening."""


@dataclass(frozen=True, eq=False)
class SelectionStep:
    """A step of the stepwise selection."""

    added: str | None
    model: FittedModel
    improvement: Improvement | None


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect of the final model."""

    term: Term
    improvement: Improvement
    """Loss of this improvement on the test rows if the effect is left out."""
    alternatives: tuple[str, ...]
    """Other effects that would explain these data equally well in its place, the closest first."""
    residuals_without: tuple[Floats, ...]
    """(m, dof) residuals of the final model without this effect, refitted, for each recording [N m]."""
    residuals_with: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of a stepwise selection."""

    steps: tuple[SelectionStep, ...]
    findings: tuple[Finding, ...]
    first_extensions: Extensions
    """Extensions of the base model."""
    last_extensions: Extensions
    """Extensions of the final model."""
    noise_floor: NoiseFloor
    computed: tuple[Floats, ...]
    """(m, dof) torque of the final model on each recording [N m]."""
