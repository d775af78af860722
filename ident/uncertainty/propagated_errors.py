"""Errors of parameters that the residual's scatter does not show, because they repeat with the motion."""

from collections.abc import Iterator, Sequence

import numpy as np

from ident.basics.statistics import TINY
from ident.data.cycle_statistics import repeating_share
from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import DRIVE_DRAWS, drive_errors, with_encoder_errors
from ident.dynamics.structure import ModelStructure
from ident.estimation.chunks import overlapping_chunks
from ident.estimation.nonlinear_fit import Solution, linearized_solution
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

DRAWS = 4
"""Number of perturbed readings that propagate encoder quantization to the parameters."""
_MIN_INDEPENDENT_SHARE = 1e-7
"""A parameter is not identifiable if less than this share of its column is independent of the other columns."""


def propagated_variance(
    recordings: Sequence[PreparedRecording], structure: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Floats:
    """(K,) mean square error of parameters `x` (K,) that were fitted to `recordings` with `weights` (m, dof).

    Of long recordings the first chunk is used, as if the rest were like it.
    """
    first = [next(overlapping_chunks(recording))[0] for recording in recordings]
    predictors = [TorquePredictor(chunk) for chunk in first]
    used = [weight[: len(chunk.torque)] for weight, chunk in zip(weights, first, strict=True)]
    share = sum(map(len, used)) / sum(map(len, weights))
    repetition = repetition_factor(recordings, [repeating_share(chunk) for chunk in first])
    solution = linearized_solution(predictors, structure, x, used)
    return PropagatedErrors(predictors, perturbed_draws(first), solution, share * repetition).variance()


def perturbed_draws(recordings: Sequence[PreparedRecording]) -> tuple[tuple[TorquePredictor, ...], ...]:
    """Several perturbations of `recordings`: random encoder errors of at most half a step."""
    return tuple(
        tuple(TorquePredictor(with_encoder_errors(recording, 1 + draw)) for recording in recordings)
        for draw in range(DRAWS)
    )


def repetition_factor(recordings: Sequence[PreparedRecording], repeating: Sequence[Floats]) -> float:
    """Variance inflation because encoder errors are partly the same in all repetitions.

    repeating: (dof,) share of each recording that repeats.
    """
    factors = []
    for recording, shares in zip(recordings, repeating, strict=True):
        cycles = max(len(np.unique(recording.repeat[recording.repeat >= 0])), 1)
        factors.append(1 + (cycles - 1) * float(shares.mean()))
    return float(np.mean(factors))


class PropagatedErrors:
    """Propagates quantization errors, and what effects idealize, to the parameters of `solution`.

    They repeat with the motion, so the residual's noise does not show them. Errors that would leave a larger residual
    than the measured one are scaled down: random encoder errors would excite a lightly damped elastic joint more than
    the real ones. Propagation is by linearized least squares.
    """

    def __init__(
        self,
        predictors: Sequence[TorquePredictor],
        perturbed: Sequence[Sequence[TorquePredictor]],
        solution: Solution,
        repetition: float,
    ) -> None:
        """Take the recordings that the `solution` was fitted to, and several draws of them with encoder errors.

        repetition: variance inflation because encoder errors repeat, as `repetition_factor`.
        """
        regressor, residual = solution.rows()
        self._predictors, self._perturbed = predictors, perturbed
        self._solution, self._repetition = solution, repetition
        self._identifiable = identifiable(solution, regressor)
        self._basis, self._triangle = np.linalg.qr(regressor[:, self._identifiable])
        self._residual = float(np.linalg.norm(residual))

    def variance(self) -> Floats:
        """(K,) mean square error due to the steps of all signals and to effects; 0 where not identifiable."""
        return self.covariance().diagonal().copy()

    def covariance(self) -> Floats:
        """(K, K) the same with the products of the errors of two parameters, which may imitate each other."""
        shifts = np.array([*self.encoder_shifts(), *self.effect_shifts(), self.attenuation_bias()])
        return shifts.T @ shifts + np.diag(self.drive_variance())

    def effect_shifts(self) -> Iterator[Floats]:
        """(K,) changes due to what each effect idealizes (its perturbed report); 0 where not identifiable."""
        structure, x = self._solution.structure, self._solution.x
        for index, _, effect in structure.signals:
            if effect.perturbed_report is not None:
                perturbed = structure.with_effect(index, effect.changed(report=effect.perturbed_report))
                errors = [each.torque(perturbed, x) - each.torque(structure, x) for each in self._predictors]
                yield self._shift(errors)

    def encoder_shifts(self) -> Iterator[Floats]:
        """(K,) changes due to the steps of the encoders; their squares add up to the mean square error."""
        structure, x = self._solution.structure, self._solution.x
        nominal = [predictor.torque(structure, x) for predictor in self._predictors]
        for draw in self._perturbed:
            pairs = zip(draw, nominal, strict=True)
            shift = self._shift([predictor.torque(structure, x) - torque for predictor, torque in pairs])
            yield np.sqrt(self._repetition / len(self._perturbed)) * shift

    def attenuation_bias(self) -> Floats:
        """(K,) bias due to the steps of the encoders; 0 where not identifiable.

        The regressor contains the same errors as the torque that is computed from it. Their product does not average
        out, and it is large beside what distinguishes two parameters that nearly imitate each other, as masses and
        inertias. One draw is enough, because the product is summed over all rows.
        """
        solution, errors = self._solution, []
        structure, x, normal = solution.structure, solution.x, np.zeros(len(solution.x))
        pairs = zip(self._predictors, self._perturbed[0], solution.weights, solution.derivatives, strict=True)
        for predictor, perturbed, weight, derivatives in pairs:
            torque, by_x = perturbed.linearized(structure, x)
            errors.append(torque - predictor.torque(structure, x))
            weighted = np.nan_to_num(weight[:, :, None] * (by_x - derivatives))
            normal += np.einsum("mjk,mj->k", weighted, np.nan_to_num(weight * errors[-1]))
        bias, known = np.zeros(len(x)), self._identifiable
        inner = np.linalg.solve(self._triangle.T, normal[known])
        bias[known] = -np.linalg.solve(self._triangle, inner) * self._scale(errors) ** 2
        return bias

    def drive_variance(self) -> Floats:
        """(K,) variance due to the steps of the drives' signal, as far as they repeat; 0 where not identifiable."""
        structure, x = self._solution.structure, self._solution.x
        errors = [drive_errors(each.prepared, each.unfiltered(structure, x)) for each in self._predictors]
        if not any(errors):
            return np.zeros(len(x))
        nothing = [(np.zeros_like(each.prepared.torque),) * 2 for each in self._predictors]
        drawn = [pairs or [none] * DRIVE_DRAWS for pairs, none in zip(errors, nothing, strict=True)]
        products = []
        for of_recordings in zip(*drawn, strict=True):
            first, second = zip(*of_recordings, strict=True)
            products.append(self._shift(first) * self._shift(second))
        return np.maximum(np.mean(products, axis=0), 0.0)

    def _shift(self, errors: Sequence[Floats]) -> Floats:
        """(K,) change of the parameters due to `errors` (m, dof) of the torque of each training recording [N m]."""
        shift = np.zeros(len(self._solution.x))
        projection = self._basis.T @ self._weighted(errors)
        shift[self._identifiable] = np.linalg.solve(self._triangle, projection) * self._scale(errors)
        return shift

    def _scale(self, errors: Sequence[Floats]) -> float:
        """Factor at most 1 after which `errors` (m, dof) leave no larger residual than the measured one."""
        weighted = self._weighted(errors)
        remaining = float(np.linalg.norm(weighted - self._basis @ (self._basis.T @ weighted)))
        return min(1.0, self._residual / max(remaining, TINY))

    def _weighted(self, errors: Sequence[Floats]) -> Floats:
        """(r,) weighted `errors` (m, dof) of all training rows."""
        pairs = zip(self._solution.weights, errors, strict=True)
        return np.concatenate([(weight * np.nan_to_num(error))[weight > 0] for weight, error in pairs])


def identifiable(solution: Solution, regressor: Floats) -> Bools:
    """(K,) identifiable parameters; regressor: (r, K)."""
    size = np.sqrt((regressor**2).sum(axis=0))
    known: Bools = np.array([entry.free for entry in solution.structure.parameters], bool) & (size > 0)
    known[known] = independent(regressor[:, known] / size[known])
    return known


def independent(columns: Floats) -> Bools:
    """(k,) False for columns (r, k) that are linear combinations of those before them."""
    diagonal = np.abs(np.diag(np.linalg.qr(columns, mode="r")))
    return diagonal > _MIN_INDEPENDENT_SHARE
