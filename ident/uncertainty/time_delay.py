"""Time delay between torque and motion of each joint: reported, not applied.

A drive signal that is early by d is tau(t + d) = tau(t) + d d(tau)/dt + ...: the time derivative of the computed
torque is a further column of the regressor, with coefficient d. All parameters are refitted with it, because they
absorb a part of any delay (viscous friction that of an inertia).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.filters import first_derivative
from ident.estimation.regression import Regression
from ident.uncertainty import covariance
from recordings.recording import Floats

_MIN_UNEXPLAINED = 1e-6
"""A column is not used if the model explains all but this share of its mean square."""


@dataclass(frozen=True)
class Delay:
    """Delay of one joint; positive if the torque follows the voltage, negative if the position is measured late."""

    seconds: float
    half_width: float
    """Half width of the 95 % interval, due to noise alone [s]."""

    def __str__(self) -> str:
        return f"{1e3 * self.seconds:+.2f} ± {1e3 * self.half_width:.2g} ms"


def delays(regressions: Sequence[Regression], parameters: Floats) -> tuple[Delay, ...] | None:
    """Delay of each joint, given the `parameters` (k,) fitted to `regressions`.

    Exact to first order: for delays that are short compared with the periods of the torque. None if the motion does
    not distinguish delays from the model's parameters.
    """
    slopes = [_slopes(regression, parameters) for regression in regressions]
    residuals = [
        np.where(np.isfinite(slope).all(axis=2), regression.residual(parameters), np.nan)
        for regression, slope in zip(regressions, slopes, strict=True)
    ]
    # The parameters absorb what they can explain of the new columns; only the independent part contains delays.
    absorbed = _explained(regressions, slopes, residuals)
    columns = [slope - regression.regressor @ absorbed for regression, slope in zip(regressions, slopes, strict=True)]
    independent, whole = _stacked(columns, residuals), _stacked(slopes, residuals)
    if ((independent**2).sum(axis=0) <= _MIN_UNEXPLAINED * (whole**2).sum(axis=0)).any():
        return None
    seconds: Floats = np.linalg.lstsq(independent, _stacked(residuals, residuals), rcond=None)[0].astype(np.float64)
    return _with_intervals(regressions, columns, residuals, seconds)


def _slopes(regression: Regression, parameters: Floats) -> Floats:
    """(m, dof, dof) time derivative of each joint's computed torque, one column for each joint."""
    slope = first_derivative(regression.predicted_torque(parameters), regression.prepared.rate)
    return np.where(np.isfinite(slope)[:, :, None], slope[:, :, None] * np.eye(slope.shape[1]), np.nan)


def _explained(regressions: Sequence[Regression], slopes: Sequence[Floats], residuals: Sequence[Floats]) -> Floats:
    """(k, dof) parameters with which the model approximates the columns `slopes` (m, dof, dof) best."""
    regressor = _stacked([regression.regressor for regression in regressions], residuals)
    # By normal equations: the solver would copy the columns themselves, which are large for long recordings.
    products = regressor.T @ regressor, regressor.T @ _stacked(slopes, residuals)
    return np.linalg.lstsq(*products, rcond=None)[0].astype(np.float64)


def _stacked(arrays: Sequence[Floats], residuals: Sequence[Floats]) -> Floats:
    """Rows of `arrays` (m, dof, ...) where there is a residual (m, dof)."""
    return np.concatenate([x[np.isfinite(residual)] for x, residual in zip(arrays, residuals, strict=True)])


def _with_intervals(
    regressions: Sequence[Regression], columns: Sequence[Floats], residuals: Sequence[Floats], seconds: Floats
) -> tuple[Delay, ...]:
    blocks = []
    for regression, column, residual in zip(regressions, columns, residuals, strict=True):
        remaining = residual - column @ seconds
        std = np.broadcast_to(np.sqrt(np.nanmean(remaining**2, axis=0)), remaining.shape)
        blocks.append(covariance.least_squares(column, remaining, std, regression.prepared.repeat))
    widths = covariance.estimate(blocks).half_width()
    return tuple(Delay(float(delay), float(width)) for delay, width in zip(seconds, widths, strict=True))
