"""Confidence intervals of the parameters of a model."""

import numpy as np

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
    """(K, 2) 95 % intervals, including noise and encoder quantization; NaN for parameters that are not identifiable.

    gain_uncertainty: relative uncertainty of the torque gain; it applies to parameters that are proportional to the
    torque.
    """
    linear = solution.structure.linear
    gain = np.where(linear, _NORMAL * gain_uncertainty * np.abs(solution.x), 0.0)
    noise, steps = parameter_uncertainty(split, solution).half_width(), _NORMAL * encoder_step_errors(split, solution)
    width = np.sqrt(noise**2 + steps**2 + gain**2)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def with_gain(intervals: Floats, solution: Solution, gain_uncertainty: float) -> Floats:
    """The `intervals` (K, 2) for an exactly known gain, widened by its relative standard uncertainty."""
    gain = np.where(solution.structure.linear, _NORMAL * gain_uncertainty * np.abs(solution.x), 0.0)
    width = np.hypot((intervals[:, 1] - intervals[:, 0]) / 2, gain)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def encoder_step_errors(split: SplitData, solution: Solution) -> Floats:
    """(K,) standard errors of the parameters of `solution` due to encoder quantization; 0 where not identifiable.

    Perturbed readings of the encoders are propagated to the parameters by linearized least squares. The errors repeat
    with the motion, so the residual's noise does not show them. A perturbation that would leave a larger residual
    than the measured one is scaled down: random errors would excite a lightly damped elastic joint more than the real
    ones.
    """
    regressor, residual = solution.rows()
    identifiable = _identifiable(solution, regressor)
    structure, x = solution.structure, solution.x
    basis, triangle = np.linalg.qr(regressor[:, identifiable])
    shifts = np.zeros((len(split.perturbed_draws), len(x)))
    nominal = [split.predictors[i].torque(structure, x) for i in split.train_indices]
    for shift, predictors in zip(shifts, split.perturbed_draws, strict=True):
        pairs = zip(solution.weights, predictors, nominal, strict=True)
        changed = np.concatenate(
            [(w * np.nan_to_num(predictor.torque(structure, x) - torque))[w > 0] for w, predictor, torque in pairs]
        )
        projection = basis.T @ changed
        remaining = max(float(np.linalg.norm(changed - basis @ projection)), _TINY)
        shift[identifiable] = np.linalg.solve(triangle, projection) * min(
            1.0, float(np.linalg.norm(residual)) / remaining
        )
    errors: Floats = np.sqrt(_repetition_factor(split) * np.mean(shifts**2, axis=0))
    return errors


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
