"""How far torque and motion are apart in time, joint by joint: reported, never applied unasked.

If what the drive measures is early by d, it is tau(t + d) = tau(t) + d d(tau)/dt + ...: a further column, the time
derivative of the computed torque, whose coefficient is d. All parameters are refitted with it, because a part of any
delay hides in them (that of an inertia in its viscous friction).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.dataset import Dataset
from ident.filters import first_derivative
from ident.uncertainty import covariance
from recordings.recording import Floats

_LEAST_OWN = 1e-6
"""A column of which the model explains all but this share of the mean square tells nothing."""


@dataclass(frozen=True)
class Delay:
    """Of one joint; positive where the torque follows the voltage, negative where the position is measured late."""

    seconds: float
    half_width: float
    """Of the 95 % interval, of the noise alone [s]."""

    def __str__(self) -> str:
        return f"{1e3 * self.seconds:+.2f} ± {1e3 * self.half_width:.2g} ms"


def delays(datasets: Sequence[Dataset], parameters: Floats) -> tuple[Delay, ...] | None:
    """The delay of each joint, given the `parameters` (k,) fitted to `datasets`.

    Exact to first order: for delays that are short against the periods of the torque. None where the motion does not
    tell delays from the model's own parameters.
    """
    own = [_slopes(dataset, parameters) for dataset in datasets]
    residuals = [
        np.where(np.isfinite(slope).all(axis=2), dataset.torque - dataset.predicted_torque(parameters), np.nan)
        for dataset, slope in zip(datasets, own, strict=True)
    ]
    # What the parameters could explain of the new columns, they will: only the rest tells of delays.
    taken = _explained(datasets, own, residuals)
    columns = [slope - dataset.regressor @ taken for dataset, slope in zip(datasets, own, strict=True)]
    rest, slopes = _stacked(columns, residuals), _stacked(own, residuals)
    if ((rest**2).sum(axis=0) <= _LEAST_OWN * (slopes**2).sum(axis=0)).any():
        return None
    seconds: Floats = np.linalg.lstsq(rest, _stacked(residuals, residuals), rcond=None)[0].astype(np.float64)
    return _with_intervals(datasets, columns, residuals, seconds)


def _slopes(dataset: Dataset, parameters: Floats) -> Floats:
    """(m, dof, dof) time derivative of each joint's computed torque, as a column of its own."""
    slope = first_derivative(dataset.predicted_torque(parameters), dataset.rate)
    columns: Floats = slope[:, :, None] * np.eye(slope.shape[1])
    return np.where(np.isfinite(slope)[:, :, None], columns, np.nan)


def _explained(datasets: Sequence[Dataset], own: Sequence[Floats], residuals: Sequence[Floats]) -> Floats:
    """(k, dof) parameters with which the model comes closest to the columns `own` (m, dof, dof)."""
    regressor = _stacked([dataset.regressor for dataset in datasets], residuals)
    # From their products: of the columns themselves, those of an hour being large, the solver would make a copy.
    products = regressor.T @ regressor, regressor.T @ _stacked(own, residuals)
    return np.linalg.lstsq(*products, rcond=None)[0].astype(np.float64)


def _stacked(arrays: Sequence[Floats], residuals: Sequence[Floats]) -> Floats:
    """The rows of `arrays` (m, dof, ...) where there is a residual (m, dof)."""
    return np.concatenate([x[np.isfinite(residual)] for x, residual in zip(arrays, residuals, strict=True)])


def _with_intervals(
    datasets: Sequence[Dataset], columns: Sequence[Floats], residuals: Sequence[Floats], seconds: Floats
) -> tuple[Delay, ...]:
    parts = []
    for dataset, column, residual in zip(datasets, columns, residuals, strict=True):
        left = residual - column @ seconds
        std = np.broadcast_to(np.sqrt(np.nanmean(left**2, axis=0)), left.shape)
        parts.append(covariance.least_squares(column, left, std, dataset.repeat))
    widths = covariance.estimate(parts).half_width()
    return tuple(Delay(float(one), float(width)) for one, width in zip(seconds, widths, strict=True))
