"""Confidence intervals of the parameters of a model."""

import numpy as np

from ident.diagnosis.split.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from ident.uncertainty.propagated_errors import PropagatedErrors, identifiable, repetition_factor
from recordings.recording import Floats

_NORMAL = 1.96
"""Half the width of a 95 % interval, in standard errors."""


def confidence_intervals(split: SplitData, solution: Solution, gain_uncertainty: float) -> Floats:
    """(K, 2) 95 % intervals, including noise and propagated errors; NaN for parameters that are not identifiable.

    gain_uncertainty: relative uncertainty of the torque gain; it applies to parameters that are proportional to the
    torque.
    """
    linear = solution.structure.linear
    gain = np.where(linear, gain_uncertainty * np.abs(solution.x), 0.0)
    noise, propagated = parameter_uncertainty(split, solution), propagated_errors(split, solution)
    width = np.sqrt(noise.half_width() ** 2 + _NORMAL**2 * (propagated.variance() + gain**2))
    return np.stack([solution.x - width, solution.x + width], axis=1)


def with_gain(intervals: Floats, solution: Solution, gain_uncertainty: float) -> Floats:
    """The `intervals` (K, 2) for an exactly known gain, widened by its relative standard uncertainty."""
    if not gain_uncertainty:
        return intervals  # not those that rounding makes of them
    gain = np.where(solution.structure.linear, _NORMAL * gain_uncertainty * np.abs(solution.x), 0.0)
    width = np.hypot((intervals[:, 1] - intervals[:, 0]) / 2, gain)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def propagated_errors(split: SplitData, solution: Solution) -> PropagatedErrors:
    """Propagation of errors that repeat with the motion to the parameters of `solution`."""
    predictors = [split.predictors[i] for i in split.train_indices]
    repetition = repetition_factor(
        [split.recordings[i] for i in split.train_indices], [split.repeating_share[i] for i in split.train_indices]
    )
    return PropagatedErrors(predictors, split.perturbed_draws, solution, repetition)


def parameter_uncertainty(split: SplitData, solution: Solution) -> Uncertainty:
    """Uncertainty of the K parameters of `solution` due to noise; NaN for parameters that are not identifiable."""
    known = identifiable(solution, solution.rows()[0])
    estimates = []
    pairs = zip(split.train_indices, solution.residuals, solution.derivatives, solution.weights, strict=True)
    for index, residual, derivatives, weight in pairs:
        measured = np.where(weight > 0, residual, np.nan)
        std = np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), 1.0)
        repeat = split.recordings[index].repeat
        estimates.append(covariance.least_squares(derivatives[:, :, known], measured, std, repeat, weight))
    return covariance.estimate(estimates).expanded(known)
