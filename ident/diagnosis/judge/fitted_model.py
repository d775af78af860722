"""A model that was fitted to the training rows, and is judged on all rows."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ident.diagnosis.judge.improvement import MIN_T, Blocks, Improvement, in_turn
from ident.diagnosis.split.noise_floor import NoiseFloor, estimate_noise_floor
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import Solution
from ident.identification.prediction import Prediction
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from ident.uncertainty.propagated_errors import PropagatedErrors, identifiable, repetition_factor
from recordings.recording import Bools, Floats


@dataclass(frozen=True, eq=False)
class FittedModel:
    """A model that was fitted to the training rows, and is judged on all rows."""

    split: SplitData
    solution: Solution

    def __reduce__(self) -> Any:
        """Pickle structure and parameters: the rest is computed again."""
        return _at, (self.split, self.solution.structure, self.solution.x)

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
        return tuple(
            recording.torque - residual
            for recording, residual in zip(self.split.recordings, self.residuals, strict=True)
        )

    @property
    def predictions(self) -> tuple[Prediction, ...]:
        """Each recording with the torque that is computed for it."""
        return tuple(map(Prediction, self.split.recordings, self.computed))

    @cached_property
    def residuals(self) -> tuple[Floats, ...]:
        """(m, dof) measured minus computed torque of each recording [N m]."""
        return self.split.residuals(self.solution)

    @cached_property
    def judged_residuals(self) -> tuple[Floats, ...]:
        """(m, dof) residuals [N m]; NaN at the rows that say nothing for or against it."""
        unjudged = self.split.unjudged(self.solution, self.noise_floor.rms)
        return tuple(
            np.where(unknown, np.nan, residual) for unknown, residual in zip(unjudged, self.residuals, strict=True)
        )

    @property
    def on_judged_rows(self) -> "FittedModel":
        """The same model, scored on the rows alone that it can be judged by."""
        # Not cached: a model that refers to itself stays, with all that it caches, until garbage is collected.
        split = self.split.judged(self.solution, self.noise_floor.rms)
        return self if split is self.split else FittedModel(split, self.solution)

    @cached_property
    def noise_floor(self) -> NoiseFloor:
        """The error that this model would leave if it were right."""
        return estimate_noise_floor(self.split, self.solution, self.residuals)

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """Uncertainty of its K parameters due to noise; NaN for those that are not identifiable."""
        solution, split = self.solution, self.split
        known, estimates = identifiable(solution, solution.rows()[0]), []
        pairs = zip(split.train_indices, solution.residuals, solution.derivatives, solution.weights, strict=True)
        for index, residual, derivatives, weight in pairs:
            measured = np.where(weight > 0, residual, np.nan)
            std = np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), 1.0)
            repeat = split.recordings[index].repeat
            estimates.append(covariance.least_squares(derivatives[:, :, known], measured, std, repeat, weight))
        return covariance.estimate(estimates).expanded(known)

    @cached_property
    def propagated_covariance(self) -> Floats:
        """(K, K) errors of its parameters that repeat with the motion; 0 where not identifiable."""
        split = self.split
        repetition = repetition_factor(
            [split.recordings[i] for i in split.train_indices],
            [split.repeating_share[i] for i in split.train_indices],
        )
        return PropagatedErrors(split.train_predictors, split.perturbed_draws, self.solution, repetition).covariance()

    @property
    def standard_errors(self) -> Floats:
        """(K,) standard errors of its parameters, due to noise and propagated errors; NaN where not identifiable."""
        return np.sqrt(self.uncertainty.std**2 + self.propagated_covariance.diagonal())

    @cached_property
    def shape_intervals(self) -> Floats:
        """(K, 2) 95 % intervals of its parameters for an exactly known torque gain, with noise and propagated errors.

        NaN where not identifiable.
        """
        return self.uncertainty.interval(self.solution.x, propagated=self.propagated_covariance.diagonal())

    @cached_property
    def turned(self) -> "FittedModel":
        """The same effects, fitted to the held-out rows."""
        split = self.split.turned
        return FittedModel(split, split.fit(self.solution.structure, self.solution.x))

    def improvement_over(
        self,
        before: "FittedModel",
        rows: Sequence[Bools] | None = None,
        compared: int = 1,
        joints: Sequence[int] | None = None,
    ) -> Improvement:
        """Improvement over the model `before`, on held-out rows or on `rows` (m, dof) of each recording.

        compared: number of models among which those rows chose this one; joints: as in `Blocks.improvement`.
        """
        return self.blocks_over(before, rows).improvement(compared, joints)

    def improvement_in_turn(
        self, before: "FittedModel", compared: int = 1, joints: Sequence[int] | None = None, required: float = MIN_T
    ) -> Improvement:
        """Improvement over the model `before` on held-out rows; t as `improvement.in_turn` has it."""
        held_out = self.blocks_over(before)

        def other_way() -> tuple[Improvement, Improvement]:
            judged = [
                rows & np.isfinite(new + old)
                for rows, new, old in zip(
                    self.split.train, self.judged_residuals, before.judged_residuals, strict=True
                )
            ]
            turned = self._blocks(before, before.turned.residuals, self.turned.residuals, judged)
            return turned.improvement(joints=joints), (held_out + turned).improvement(joints=joints)

        return in_turn(held_out.improvement(compared, joints), other_way, required)

    def blocks_over(self, before: "FittedModel", rows: Sequence[Bools] | None = None) -> Blocks:
        """Blocks of the held-out rows, or of `rows` (m, dof), that both models can judge.

        The others tell nothing about the effect.
        """
        rows = self.split.test if rows is None else rows
        return self._blocks(before, before.judged_residuals, self.judged_residuals, rows)

    def _blocks(
        self, before: "FittedModel", old: Sequence[Floats], new: Sequence[Floats], rows: Sequence[Bools]
    ) -> Blocks:
        smoothed = (before.noise_floor.smoothed, self.noise_floor.smoothed)
        return Blocks.of(self.split, old, new, self.noise_floor.certain, rows, smoothed)


def _at(split: SplitData, structure: ModelStructure, x: Floats) -> FittedModel:
    """The model `structure` with the fitted parameters `x` (K,)."""
    return FittedModel(split, split.at(structure, x))
