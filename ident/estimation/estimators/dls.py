"""Damped least squares on the linear regression model (37)-(40), after reference [18] of the paper.

Minimises |torque - Psi theta|^2 + (damping s)^2 |theta|^2, where s is the largest singular value of Psi. The paper
does not print the damping; a thousandth affects only directions that the motion hardly excites.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Meaning

FORM = "lagrange14"


@dataclass(frozen=True)
class Settings:
    """Settings of damped least squares."""

    damping: Annotated[float, Meaning("damping relative to the largest singular value of the regressor", least=0)] = (
        1e-3
    )


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Scale each component along a singular vector by s_i / (s_i^2 + damping^2), instead of 1 / s_i."""
    U, singular, Vt = np.linalg.svd(problem.regressor, full_matrices=False)
    damping = settings.damping * singular[0]
    parameters = Vt.T @ (singular / (singular**2 + damping**2) * (U.T @ problem.torque))
    residual = problem.torque - problem.regressor @ parameters
    objective = float(residual @ residual + damping**2 * parameters @ parameters)
    progress(1, 1)
    return Estimate(parameters, objective, np.array([objective]))
