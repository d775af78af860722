"""Data of a stepwise selection: models, their extensions, steps and findings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from ident.diagnosis.judge.improvement import Improvement, measure_improvement
from ident.diagnosis.split.noise_floor import NoiseFloor, estimate_noise_floor
from ident.diagnosis.split.parameter_intervals import confidence_intervals, parameter_uncertainty, propagated_errors
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.identification.prediction import Prediction
from ident.uncertainty.covariance import Uncertainty
from recordings.recording import Bools, Floats

Exclusion = Literal["collinear", "sign"]
"""collinear: other parameters reproduce its torque; sign: its coefficient would need an impossible sign."""


@dataclass(frozen=True, eq=False)
class FittedModel:
    """A model that was fitted to the training rows, and is judged on all rows."""

    split: SplitData
    solution: Solution

    @property
    def terms(self) -> tuple[Term, ...]:
        """Its effects."""
        return self.solution.structure.terms

    @property
    def names(self) -> set[str]:
        """Names of its effects."""
        return {term.name for term in self.terms}

    @cached_property
    def computed(self) -> tuple[Floats, ...]:
        """(m, dof) torque on each recording [N m]."""
        pairs = zip(self.split.recordings, self.residuals, strict=True)
        return tuple(recording.torque - residual for recording, residual in pairs)

    @property
    def predictions(self) -> tuple[Prediction, ...]:
        """Each recording with the torque that is computed for it."""
        return tuple(map(Prediction, self.split.recordings, self.computed))

    @cached_property
    def residuals(self) -> tuple[Floats, ...]:
        """(m, dof) measured minus computed torque of each recording [N m]."""
        return self.split.residuals(self.solution)

    @property
    def curve_joints(self) -> frozenset[int]:
        """Joints (from 0) on which one of its effects is a curve."""
        return frozenset(joint for term in self.terms if term.effect.curve for joint in term.joints)

    @property
    def extrapolated(self) -> tuple[Bools, ...]:
        """(m, dof) rows of each recording at which one of its curves is not known: outside of the training travel."""
        with_curve = np.isin(np.arange(self.solution.structure.rig.dof), list(self.curve_joints))
        return tuple(rows & with_curve for rows in self.split.outside_of_travel)

    @cached_property
    def _judged_residuals(self) -> tuple[Floats, ...]:
        """The residuals; NaN where the model is extrapolated."""
        if not self.curve_joints:
            return self.residuals
        pairs = zip(self.extrapolated, self.residuals, strict=True)
        return tuple(np.where(unknown, np.nan, residual) for unknown, residual in pairs)

    @cached_property
    def noise_floor(self) -> NoiseFloor:
        """The error that this model would leave if it were right."""
        return estimate_noise_floor(self.split, self.solution, self.residuals)

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """Uncertainty of its K parameters due to noise."""
        return parameter_uncertainty(self.split, self.solution)

    @cached_property
    def propagated_variance(self) -> Floats:
        """(K,) mean square error of its parameters that repeats with the motion; 0 where not identifiable."""
        return propagated_errors(self.split, self.solution).variance()

    @property
    def standard_errors(self) -> Floats:
        """(K,) standard errors of its parameters, due to noise and propagated errors; NaN where not identifiable."""
        errors: Floats = np.sqrt(self.uncertainty.std**2 + self.propagated_variance)
        return errors

    @cached_property
    def shape_intervals(self) -> Floats:
        """(K, 2) 95 % intervals of its parameters for an exactly known torque gain; NaN where not identifiable."""
        return confidence_intervals(self.split, self.solution, 0.0)

    def improvement_over(
        self, before: "FittedModel", rows: Sequence[Bools] | None = None, compared: int = 1
    ) -> Improvement:
        """Improvement over the model `before`, on test rows or on `rows` (m, dof) of each recording.

        Rows at which one of both is extrapolated are left out: they tell nothing about the effect.

        compared: number of models among which those rows chose this one.
        """
        floor = self.noise_floor.rms
        return measure_improvement(
            self.split, before._judged_residuals, self._judged_residuals, floor, rows, compared
        )


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
    compared: int = 1
    """Number of models among which the test rows chose this effect; the interval of the improvement allows for it."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Result of a stepwise selection."""

    steps: tuple[SelectionStep, ...]
    findings: tuple[Finding, ...]
    first_extensions: Extensions
    """Extensions of the base model."""
    last_extensions: Extensions
    """Extensions of the final model."""
    refused: Mapping[str, str] = field(default_factory=dict)
    """Effects that were refused because they cannot be true, with the last reason."""

    @property
    def model(self) -> FittedModel:
        """The final model."""
        return self.steps[-1].model
