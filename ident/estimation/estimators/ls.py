"""Plain least squares on the mechanism's own model, the 11 parameters of (30).

Not in the paper. A fair counterpart of its baselines RLS, DLS and SVD: their objective with the regressor of the
swarm. The search region is ignored.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from recordings.recording import Floats


@dataclass(frozen=True)
class Settings:
    """No settings."""


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals."""
    parameters: Floats = np.asarray(np.linalg.lstsq(problem.regressor, problem.torque, rcond=None)[0], np.float64)
    objective = float(np.sum((problem.torque - problem.regressor @ parameters) ** 2))
    progress(1, 1)
    return Estimate(parameters, objective, np.array([objective]))
