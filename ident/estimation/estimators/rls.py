"""Recursive least squares on the linear regression model (37)-(40), after reference [17] of the paper: Islam,
Bernstein, IEEE Control Syst. Mag. 39 (2019), 82-85.

For each row psi with torque tau, starting from theta = 0 and the covariance P = covariance * identity:

    P     <- P / forgetting, at the first row of an instant
    P     <- P - P psi psi' P / (1 + psi' P psi)
    theta <- theta + P psi (tau - psi' theta)

The rows of an instant one after the other give the same as all of them together. The paper prints neither forgetting
nor initial covariance. The parameters are constant, so that nothing is forgotten unless asked for, and then the order
of the rows makes no difference; the covariance is large, so that the initial value is irrelevant.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.random import Generator

from ident.basics.numba_cache import compiled
from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Meaning
from recordings.errors import BadInput

FORM = "lagrange14"
RECURSIVE = True


@dataclass(frozen=True)
class Settings:
    """Settings of recursive least squares."""

    covariance: Annotated[float, Meaning("initial variance of each parameter", above=0)] = 1e6
    forgetting: Annotated[
        float, Meaning("weight of an instant relative to the next one; 1: none is forgotten", least=0.5, most=1)
    ] = 1.0


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Process all rows once: minimise the sum of squares plus |theta|^2 / covariance, the old weighing less."""
    regressor, torque = np.ascontiguousarray(problem.regressor), np.ascontiguousarray(problem.torque)
    instant = np.zeros(len(torque), np.int64) if problem.instant is None else problem.instant
    if settings.forgetting < 1:
        order = np.argsort(instant, kind="stable")
        regressor, torque, instant = regressor[order], torque[order], instant[order]
    first_of_instant = np.concatenate([[False], np.diff(instant) > 0]) & (settings.forgetting < 1)
    parameters = _recursion()(regressor, torque, first_of_instant, settings.covariance, settings.forgetting)
    if not np.isfinite(parameters).all():
        raise BadInput(
            f"a forgetting factor at which the recursion stays finite expected, {settings.forgetting:g} found; "
            "give a larger one"
        )
    weight = settings.forgetting ** (first_of_instant.sum() - np.cumsum(first_of_instant))
    residual = torque - regressor @ parameters
    initial = settings.forgetting ** first_of_instant.sum() / settings.covariance
    objective = float(weight * residual @ residual + initial * parameters @ parameters)
    progress(1, 1)
    return Estimate(parameters, objective, np.array([objective]))


@lru_cache
def _recursion() -> Any:
    def recursion(regressor: Any, torque: Any, first_of_instant: Any, covariance: float, forgetting: float) -> Any:
        k = regressor.shape[1]
        P = covariance * np.eye(k)
        theta = np.zeros(k)
        gain = np.empty(k)
        for row in range(len(torque)):
            if first_of_instant[row]:
                P /= forgetting
            psi = regressor[row]
            innovation = torque[row]
            scale = 1.0
            for i in range(k):
                gain[i] = 0.0
                for j in range(k):
                    gain[i] += P[i, j] * psi[j]
                scale += psi[i] * gain[i]
                innovation -= psi[i] * theta[i]
            for i in range(k):
                # The gain equals the updated P times psi.
                theta[i] += gain[i] / scale * innovation
                for j in range(k):
                    P[i, j] -= gain[i] * gain[j] / scale
        return theta

    return compiled(recursion)
