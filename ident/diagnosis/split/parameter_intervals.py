"""Confidence intervals of the parameters of a model."""

import numpy as np

from ident.diagnosis.split.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from ident.uncertainty import covariance
from ident.uncertainty.covariance import LEVEL, Uncertainty
from ident.uncertainty.propagated_errors import PropagatedErrors, identifiable, repetition_factor
from recordings.recording import Floats


def confidence_intervals(split: SplitData, solution: Solution) -> Floats:
    """(K, 2) 95 % intervals for an exactly known torque gain, including noise and propagated errors.

    NaN for parameters that are not identifiable.
    """
    propagated = propagated_errors(split, solution).variance()
    return parameter_uncertainty(split, solution).interval(solution.x, propagated=propagated)


def with_gain(intervals: Floats, solution: Solution, gain_uncertainty: float) -> Floats:
    """The `intervals` (K, 2) for an exactly known gain, widened by its relative standard uncertainty.

    It applies to the parameters that are proportional to the torque.
    """
    from scipy.special import ndtri

    if not gain_uncertainty:
        return intervals  # not those that rounding makes of them
    proportional = np.where(solution.structure.linear, np.abs(solution.x), 0.0)
    gain = ndtri((1 + LEVEL) / 2) * gain_uncertainty * proportional
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
