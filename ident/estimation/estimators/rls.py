"""Recursive least squares on the linear regression model (37)-(40), after reference [17] of the paper: Islam,
Bernstein, IEEE Control Syst. Mag. 39 (2019), 82-85.

For each row psi with torque tau, starting from theta = 0 and the covariance P = covariance * identity:

    P     <- P - P psi psi' P / (1 + psi' P psi)
    theta <- theta + P psi (tau - psi' theta)

Interpretation: there is no forgetting, as the parameters are constant. Then neither the order of the rows nor joint
processing of the three rows of an instant makes a difference. The paper prints no initial covariance; it is large
here, so that the initial value is irrelevant.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from ident.numba_cache import compiled
from recordings.errors import BadInput

FORM = "lagrange14"


@dataclass(frozen=True)
class Settings:
    """Settings of recursive least squares."""

    covariance: float = 1e6
    """Initial variance of each parameter."""

    def __post_init__(self) -> None:
        if not self.covariance > 0:
            raise BadInput(f"a covariance above 0 expected, {self.covariance:g} found; change it")


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Process all rows once, which minimises the sum of squares plus |theta|^2 / covariance."""
    regressor, torque = np.ascontiguousarray(problem.regressor), np.ascontiguousarray(problem.torque)
    parameters = _recursion()(regressor, torque, settings.covariance)
    residual = torque - regressor @ parameters
    objective = float(residual @ residual + parameters @ parameters / settings.covariance)
    progress(1, 1)
    return Estimate(parameters, objective, np.array([objective]))


@lru_cache
def _recursion() -> Any:
    def recursion(regressor: Any, torque: Any, covariance: float) -> Any:
        k = regressor.shape[1]
        P = covariance * np.eye(k)
        theta = np.zeros(k)
        gain = np.empty(k)
        for row in range(len(torque)):
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
