"""Linear fit of a model to recordings: search region, estimator, parameters at a bound."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from ident.data.row_weights import FittedRows, fitted_rows
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.mechanisms.urdf import Urdf
from ident.estimation import estimators
from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.regression import Regression
from recordings.errors import BadInput, told
from recordings.recording import Floats, Ints

SEARCH_FACTOR = 10.0
"""Limit of a single model term (parameter times column) relative to the torque (both RMS)."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Fitted linear parameters of a model."""

    estimate: Estimate
    bounds: Floats
    """(k, 2) search region."""
    rows: int
    """Joint samples used."""

    @property
    def parameters(self) -> Floats:
        """(k,)."""
        return self.estimate.parameters

    @property
    def at_bound(self) -> tuple[bool, ...]:
        """For each parameter, whether its estimate is at a bound of the search region, not determined by the data.

        Methods without a search region may exceed the bounds.
        """
        from_edge = np.abs(self.parameters[:, None] - self.bounds).min(axis=1)
        on_edge = from_edge <= 1e-6 * np.ptp(self.bounds, axis=1)
        return tuple(bool(flag) for flag in on_edge)


def fit(
    regressions: Sequence[Regression],
    parameters: Sequence[Parameter],
    method: str,
    settings: Any,
    generator: Generator,
    progress: Progress,
    physical: bool = False,
    links: Urdf | None = None,
    rows: FittedRows | None = None,
) -> Fit:
    """Estimate the linear `parameters` (k,) from all `regressions`, by the estimator `method` with its `settings`.

    physical: friction must oppose motion too; masses and inertias are never searched below zero.
    links: that least squares allows to be bodies alone.
    rows: `fitted_rows` of the recordings, if they are known already.

    Raises:
        BadInput: a parameter has no effect on the torque; or the result must be `physical`, but the method ignores
            the search region and left it.
    """
    regressor, torque = _rows(regressions)
    bounds = search_region(parameters, regressor, torque, physical)
    deviation = _deviation(regressions, rows) if estimators.declares(method, "WEIGHTED") else None
    instant = _instants(regressions) if estimators.declares(method, "RECURSIVE") else None
    problem = Problem(regressor, torque, bounds, deviation, instant, links)
    estimate = estimators.load(method).estimate(problem, generator, progress, settings)
    if physical:
        _check_physical(parameters, estimate.parameters, bounds, method)
    return Fit(estimate, bounds, len(torque))


def _rows(regressions: Sequence[Regression]) -> tuple[Floats, Floats]:
    """Regressor (r, k) and torque (r,) of all `regressions`."""
    if len(regressions) == 1:
        return regressions[0].rows()  # no copy: the arrays of long recordings are large
    regressors, torques = zip(*(regression.rows() for regression in regressions), strict=True)
    return np.concatenate(regressors), np.concatenate(torques)


def _instants(regressions: Sequence[Regression]) -> Ints:
    """Number (r,) of the instant of each row, counted through all `regressions`."""
    ends = np.cumsum([len(regression.torque) for regression in regressions])
    return np.concatenate(
        [
            first + np.nonzero(np.isfinite(regression.torque).T)[1]
            for first, regression in zip([0, *ends[:-1]], regressions, strict=True)
        ]
    )


def _check_physical(parameters: Sequence[Parameter], values: Floats, bounds: Floats, method: str) -> None:
    for parameter, value, lowest in zip(parameters, values, bounds[:, 0], strict=True):
        if parameter.physically_positive and value < lowest:
            raise BadInput(
                f"method {method} ignores the search region: {parameter.name} of 0 or more expected, "
                f"{value:.4g} {parameter.unit} found; choose pso or lad, or "
                f"leave out {told('--physical', 'physical')}"
            )


def _deviation(regressions: Sequence[Regression], rows: FittedRows | None) -> Floats:
    """Standard deviation (r,) [N m] of the residual in each row; infinite where the joint stands still."""
    rows = rows or fitted_rows([regression.prepared for regression in regressions])
    deviations = [
        np.where(moving, 1 / weights, np.inf).T[np.isfinite(regression.torque).T]
        for regression, moving, weights in zip(regressions, rows.rows, rows.weights, strict=True)
    ]
    return np.concatenate(deviations)


def search_region(
    parameters: Sequence[Parameter], regressor: Floats, torque: Floats, physical: bool = False
) -> Floats:
    """Bounds (k, 2) for fitting torque (m,) [N m] by regressor (m, k).

    The RMS of each term (parameter times column) is limited to SEARCH_FACTOR times the RMS of the torque, since
    larger terms would have to cancel each other at every sample. So the region scales with the size of the robot and
    with an unknown gain. Masses and inertias are bounded by zero. Friction is not, unless `physical`: a fit may yield
    negative coefficients, as in (36), and the user should see them.

    Raises:
        BadInput: a parameter has no effect on the torque.
    """
    column_rms = np.sqrt(np.mean(regressor**2, axis=0))
    for parameter, rms in zip(parameters, column_rms, strict=True):
        if rms == 0:
            raise BadInput(
                f"every parameter needs a motion that shows it, but {parameter.name} ({parameter.meaning}) has no "
                "effect on this one; record a richer motion"
            )
    highest = SEARCH_FACTOR * np.sqrt(np.mean(torque**2)) / column_rms
    from_zero = np.array([parameter.nonnegative or (physical and parameter.friction) for parameter in parameters])
    return np.stack([np.where(from_zero, 0.0, -highest), highest], axis=1)
