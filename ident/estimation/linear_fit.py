"""Fitting a mechanism to data sets: search region, estimator, parameters on a bound."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from ident.data import noise
from ident.data.dataset import Dataset
from ident.dynamics.mechanisms import Mechanism, Parameter
from ident.estimation import estimators
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput
from recordings.recording import Floats

SEARCH_FACTOR = 10.0
"""No single term of the model is searched beyond so many times the torque it is to explain."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters of a mechanism and how they were found."""

    estimate: Estimate
    bounds: Floats
    """(k, 2) search region."""
    rows: int
    """Joint samples used."""

    @property
    def parameters(self) -> Floats:
        """(k,)"""
        return self.estimate.parameters

    @property
    def at_bound(self) -> tuple[bool, ...]:
        """For each parameter, whether it ended on the edge of the search region, which then decided, not the data.

        Methods that do not search may end beyond.
        """
        from_edge = np.abs(self.parameters[:, None] - self.bounds).min(axis=1)
        on_edge = from_edge <= 1e-6 * np.ptp(self.bounds, axis=1)
        return tuple(bool(flag) for flag in on_edge)

    def torque(self, dataset: Dataset) -> Floats:
        """Torque (m, dof) [N m] that the model computes for `dataset`."""
        return dataset.predicted_torque(self.parameters)


def fit(
    datasets: Sequence[Dataset],
    mechanism: Mechanism,
    method: str,
    settings: Any,
    generator: Generator,
    progress: Progress,
    physical: bool = False,
) -> Fit:
    """Find the parameters of `mechanism` from `datasets` together, by the estimator `method` with its `settings`.

    If `physical`, friction must oppose motion too; masses and inertias are never searched below zero.

    Raises:
        BadInput: the motion leaves a parameter without any effect; or the result was to be physical, but the method
            does not look at the search region, and left it.
    """
    regressor, torque = _rows(datasets)
    bounds = search_region(mechanism.parameters, regressor, torque, physical)
    deviation = _deviation(datasets, regressor, torque) if estimators.weighted(method) else None
    problem = Problem(regressor, torque, bounds, deviation)
    estimate = estimators.load(method).estimate(problem, generator, progress, settings)
    if physical:
        _refuse_unphysical(mechanism.parameters, estimate.parameters, bounds, method)
    return Fit(estimate, bounds, len(torque))


def _rows(datasets: Sequence[Dataset]) -> tuple[Floats, Floats]:
    """Regressor (r, k) and torque (r,) of all `datasets`."""
    if len(datasets) == 1:
        return datasets[0].rows()  # no copy: those of an hour are large
    regressors, torques = zip(*(dataset.rows() for dataset in datasets), strict=True)
    return np.concatenate(regressors), np.concatenate(torques)


def _refuse_unphysical(parameters: Sequence[Parameter], values: Floats, bounds: Floats, method: str) -> None:
    for parameter, value, lowest in zip(parameters, values, bounds[:, 0], strict=True):
        if parameter.physically_positive and value < lowest:
            raise BadInput(
                f"method {method} does not keep to a search region: {parameter.name} of 0 or more expected, "
                f"{value:.4g} {parameter.unit} found; choose pso or lad, or leave out --physical"
            )


def _deviation(datasets: Sequence[Dataset], regressor: Floats, torque: Floats) -> Floats:
    """(r,) standard deviation [N m] of what a fit leaves in each row, by the noise that a first fit shows."""
    first = np.linalg.lstsq(regressor, torque, rcond=None)[0].astype(np.float64)
    residuals = [dataset.torque - dataset.predicted_torque(first) for dataset in datasets]
    found = noise.estimate(datasets, residuals)
    deviations = [
        noise.residual_std(dataset, residual, found).T[np.isfinite(dataset.torque).T]
        for dataset, residual in zip(datasets, residuals, strict=True)
    ]
    return np.concatenate(deviations)


def search_region(
    parameters: Sequence[Parameter], regressor: Floats, torque: Floats, physical: bool = False
) -> Floats:
    """Bounds (k, 2) for fitting torque (m,) [N m] by regressor (m, k).

    A term (parameter times column) that were alone many times larger than the torque would have to be cancelled by
    the others at every sample; so its RMS is limited to REACH times the torque's. That makes the region follow the
    robot's size and an unknown gain. Masses and inertias stop at zero. Friction does not: (36) shows that a fit may
    want a negative coefficient, which the user should see; only if `physical` does it stop at zero too.

    Raises:
        BadInput: the motion leaves a parameter without any effect.
    """
    size = np.sqrt(np.mean(regressor**2, axis=0))
    for parameter, column in zip(parameters, size, strict=True):
        if column == 0:
            raise BadInput(
                f"every parameter needs a motion that shows it, but {parameter.name} ({parameter.meaning}) has no "
                "effect on this one; record a richer motion"
            )
    highest = SEARCH_FACTOR * np.sqrt(np.mean(torque**2)) / size
    from_zero = np.array([parameter.nonnegative or (physical and parameter.friction) for parameter in parameters])
    return np.stack([np.where(from_zero, 0.0, -highest), highest], axis=1)
