"""Confidence intervals of the parameters of a model."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ident.data.quantization import DRIVE_DRAWS, drive_errors
from ident.diagnosis.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from recordings.recording import Bools, Floats

_NORMAL = 1.96
"""Half the width of a 95 % interval, in standard errors."""
_TINY = 1e-12
_MIN_INDEPENDENT_SHARE = 1e-7
"""A parameter is not identifiable if less than this share of its column is independent of the other columns."""


def confidence_intervals(split: SplitData, solution: Solution, gain_uncertainty: float) -> Floats:
    """(K, 2) 95 % intervals, including noise and propagated errors; NaN for parameters that are not identifiable.

    gain_uncertainty: relative uncertainty of the torque gain; it applies to parameters that are proportional to the
    torque.
    """
    linear = solution.structure.linear
    gain = np.where(linear, gain_uncertainty * np.abs(solution.x), 0.0)
    noise, propagated = parameter_uncertainty(split, solution), PropagatedErrors(split, solution)
    width = np.sqrt(noise.half_width() ** 2 + _NORMAL**2 * (propagated.variance() + gain**2))
    return np.stack([solution.x - width, solution.x + width], axis=1)


def with_gain(intervals: Floats, solution: Solution, gain_uncertainty: float) -> Floats:
    """The `intervals` (K, 2) for an exactly known gain, widened by its relative standard uncertainty."""
    gain = np.where(solution.structure.linear, _NORMAL * gain_uncertainty * np.abs(solution.x), 0.0)
    width = np.hypot((intervals[:, 1] - intervals[:, 0]) / 2, gain)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def standard_errors(split: SplitData, solution: Solution) -> Floats:
    """(K,) standard errors of the parameters of `solution`, due to noise and propagated errors; NaN: not
    identifiable."""
    noise = parameter_uncertainty(split, solution).std
    errors: Floats = np.sqrt(noise**2 + PropagatedErrors(split, solution).variance())
    return errors


class PropagatedErrors:
    """Propagates quantization errors, and what effects idealize, to the parameters of `solution`.

    They repeat with the motion, so the residual's noise does not show them. Errors that would leave a larger residual
    than the measured one are scaled down: random encoder errors would excite a lightly damped elastic joint more than
    the real ones. Propagation is by linearized least squares.
    """

    def __init__(self, split: SplitData, solution: Solution) -> None:
        regressor, residual = solution.rows()
        self._split, self._solution = split, solution
        self._identifiable = _identifiable(solution, regressor)
        self._basis, self._triangle = np.linalg.qr(regressor[:, self._identifiable])
        self._residual = float(np.linalg.norm(residual))

    def variance(self) -> Floats:
        """(K,) mean square error due to the steps of all signals and to effects; 0 where not identifiable."""
        variance = self.encoder_variance() + self.drive_variance() + self.effect_variance()
        return variance + self.attenuation_bias() ** 2

    def effect_variance(self) -> Floats:
        """(K,) variance due to what effects idealize (their perturbed reports); 0 where not identifiable."""
        structure, x = self._solution.structure, self._solution.x
        predictors = [self._split.predictors[i] for i in self._split.train_indices]
        variance = np.zeros(len(x))
        for index, _, effect in structure.signals:
            if effect.perturbed_report is not None:
                perturbed = structure.with_effect(index, replace(effect, report=effect.perturbed_report))
                errors = [each.torque(perturbed, x) - each.torque(structure, x) for each in predictors]
                variance += self._shift(errors) ** 2
        return variance

    def encoder_variance(self) -> Floats:
        """(K,) variance due to the steps of the encoders; 0 where not identifiable."""
        split, structure, x = self._split, self._solution.structure, self._solution.x
        nominal = [split.predictors[i].torque(structure, x) for i in split.train_indices]
        shifts = np.array(
            [
                self._shift(
                    [predictor.torque(structure, x) - torque for predictor, torque in zip(draw, nominal, strict=True)]
                )
                for draw in split.perturbed_draws
            ]
        )
        variance: Floats = _repetition_factor(split) * np.mean(shifts**2, axis=0)
        return variance

    def attenuation_bias(self) -> Floats:
        """(K,) bias due to the steps of the encoders; 0 where not identifiable.

        The regressor contains the same errors as the torque that is computed from it. Their product does not average
        out, and it is large beside what distinguishes two parameters that nearly imitate each other, as masses and
        inertias. One draw is enough, because the product is summed over all rows.
        """
        solution, split = self._solution, self._split
        normal, errors = np.zeros(len(solution.x)), []
        indexed = zip(split.train_indices, split.perturbed_draws[0], strict=True)
        for (index, perturbed), weight, derivatives in zip(
            indexed, solution.weights, solution.derivatives, strict=True
        ):
            nominal = split.predictors[index].torque(solution.structure, solution.x)
            torque, by_x = perturbed.linearized(solution.structure, solution.x)
            error = np.nan_to_num(weight * (torque - nominal))
            normal += np.einsum("mjk,mj->k", np.nan_to_num(weight[:, :, None] * (by_x - derivatives)), error)
            errors.append(torque - nominal)
        bias, identifiable = np.zeros(len(solution.x)), self._identifiable
        inner = np.linalg.solve(self._triangle.T, normal[identifiable])
        bias[identifiable] = -np.linalg.solve(self._triangle, inner) * self._scale(errors) ** 2
        return bias

    def drive_variance(self) -> Floats:
        """(K,) variance due to the steps of the drives' signal, as far as they repeat; 0 where not identifiable."""
        structure, x = self._solution.structure, self._solution.x
        predictors = [self._split.predictors[i] for i in self._split.train_indices]
        errors = [drive_errors(each.prepared, each.unfiltered(structure, x)) for each in predictors]
        if not any(errors):
            return np.zeros(len(x))
        nothing = [(np.zeros_like(each.prepared.torque),) * 2 for each in predictors]
        drawn = [pairs or [none] * DRIVE_DRAWS for pairs, none in zip(errors, nothing, strict=True)]
        products = []
        for of_recordings in zip(*drawn, strict=True):
            first, second = zip(*of_recordings, strict=True)
            products.append(self._shift(first) * self._shift(second))
        variance: Floats = np.maximum(np.mean(products, axis=0), 0.0)
        return variance

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
        return min(1.0, self._residual / max(remaining, _TINY))

    def _weighted(self, errors: Sequence[Floats]) -> Floats:
        """(r,) weighted `errors` (m, dof) of all training rows."""
        pairs = zip(self._solution.weights, errors, strict=True)
        return np.concatenate([(weight * np.nan_to_num(error))[weight > 0] for weight, error in pairs])


def _repetition_factor(split: SplitData) -> float:
    """Variance inflation because encoder errors are partly the same in all repetitions."""
    factors = []
    for index in split.train_indices:
        repeat = split.recordings[index].repeat
        cycles = max(len(np.unique(repeat[repeat >= 0])), 1)
        factors.append(1 + (cycles - 1) * float(split.repeating_share[index].mean()))
    return float(np.mean(factors))


def parameter_uncertainty(split: SplitData, solution: Solution) -> Uncertainty:
    """Uncertainty of the K parameters of `solution` due to noise; NaN for parameters that are not identifiable."""
    identifiable = _identifiable(solution, solution.rows()[0])
    estimates = []
    pairs = zip(split.train_indices, solution.residuals, solution.derivatives, solution.weights, strict=True)
    for index, residual, derivatives, weight in pairs:
        known = np.where(weight > 0, residual, np.nan)
        std = np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), 1.0)
        repeat = split.recordings[index].repeat
        estimates.append(covariance.least_squares(derivatives[:, :, identifiable], known, std, repeat, weight))
    return covariance.estimate(estimates).expanded(identifiable)


def _identifiable(solution: Solution, regressor: Floats) -> Bools:
    """(K,) identifiable parameters; regressor: (r, K)."""
    size = np.sqrt((regressor**2).sum(axis=0))
    identifiable: Bools = np.array([entry.free for entry in solution.structure.parameters], bool) & (size > 0)
    identifiable[identifiable] = _independent(regressor[:, identifiable] / size[identifiable])
    return identifiable


def _independent(columns: Floats) -> Bools:
    """(k,) False for columns (r, k) that are linear combinations of those before them."""
    diagonal = np.abs(np.diag(np.linalg.qr(columns, mode="r")))
    independent: Bools = diagonal > _MIN_INDEPENDENT_SHARE
    return independent
