"""How well the parameters of a composition are known."""

import numpy as np

from ident.diagnosis.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from recordings.recording import Bools, Floats

_NORMAL = 1.96
"""Half the width of a 95 % interval, in standard errors."""
_TINY = 1e-12
_DEPENDENT = 1e-7
"""Share of a column that others do not make up, below which nothing is known of its parameter."""


def confidence_intervals(material: SplitData, solution: Solution, gain_uncertainty: float) -> Floats:
    """(K, 2) 95 % intervals, of the noise and the encoders' steps; NaN for what the data do not tell.

    gain_uncertainty: relative, of the torque gain; it counts for what is proportional to the torque.
    """
    linear = solution.composition.linear
    gain = np.where(linear, _NORMAL * gain_uncertainty * np.abs(solution.x), 0.0)
    noise, steps = parameter_uncertainty(material, solution).half_width(), _NORMAL * encoder_step_errors(material, solution)
    width = np.sqrt(noise**2 + steps**2 + gain**2)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def encoder_step_errors(material: SplitData, solution: Solution) -> Floats:
    """(K,) standard errors of the parameters of `solution` because of the encoders' steps; 0 where none are told.

    From readings as they might have been, each of which would have led to other parameters: their errors repeat with
    the motion, so that the residual's noise tells nothing of them. What such a reading would leave is no more than
    what is left: an arm on a spring with little damping would be shaken by errors drawn by lot, but was not.
    """
    regressor, residual = solution.rows()
    told = _told(solution, regressor)
    composition, x = solution.composition, solution.x
    basis, triangle = np.linalg.qr(regressor[:, told])
    shifts = np.zeros((len(material.perturbed_draws), len(x)))
    read = [material.predictors[i].torque(composition, x) for i in material.train_indices]
    for shift, misread in zip(shifts, material.perturbed_draws, strict=True):
        parts = zip(solution.weights, misread, read, strict=True)
        changed = np.concatenate(
            [(w * np.nan_to_num(other.torque(composition, x) - one))[w > 0] for w, other, one in parts]
        )
        along = basis.T @ changed
        left = max(float(np.linalg.norm(changed - basis @ along)), _TINY)
        shift[told] = np.linalg.solve(triangle, along) * min(1.0, float(np.linalg.norm(residual)) / left)
    again: Floats = np.sqrt(_alike(material) * np.mean(shifts**2, axis=0))
    return again


def _alike(material: SplitData) -> float:
    """How much larger a variance is because the encoders' errors are the same in all repetitions, in part."""
    found = []
    for index in material.train_indices:
        repeat = material.datasets[index].repeat
        cycles = max(len(np.unique(repeat[repeat >= 0])), 1)
        found.append(1 + (cycles - 1) * float(material.repeating_share[index].mean()))
    return float(np.mean(found))


def parameter_uncertainty(material: SplitData, solution: Solution) -> Uncertainty:
    """Of the K parameters of `solution`; NaN for what the data do not tell."""
    told = _told(solution, solution.rows()[0])
    parts = []
    pairs = zip(material.train_indices, solution.residuals, solution.derivatives, solution.weights, strict=True)
    for index, residual, derivatives, weight in pairs:
        known = np.where(weight > 0, residual, np.nan)
        std = np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), 1.0)
        repeat = material.datasets[index].repeat
        parts.append(covariance.least_squares(derivatives[:, :, told], known, std, repeat, weight))
    return covariance.of(parts).among(told)


def _told(solution: Solution, regressor: Floats) -> Bools:
    """(K,) of which parameters the data say anything; regressor: (r, K)."""
    size = np.sqrt((regressor**2).sum(axis=0))
    told: Bools = np.array([entry.free for entry in solution.composition.named], bool) & (size > 0)
    told[told] = _independent(regressor[:, told] / size[told])
    return told


def _independent(columns: Floats) -> Bools:
    """(k,) False for columns (r, k) that those before them make up."""
    diagonal = np.abs(np.diag(np.linalg.qr(columns, mode="r")))
    independent: Bools = diagonal > _DEPENDENT
    return independent
