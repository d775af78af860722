"""Plain least squares on the mechanism's own model, the 11 parameters of (30).

Not in the paper. A fair counterpart of its baselines RLS, DLS and SVD: their objective with the regressor of the
swarm. The search region is ignored, but links that shall be bodies are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation import possible_links
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.recording import Floats


@dataclass(frozen=True)
class Settings:
    """No settings."""


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals."""
    regressor, torque = problem.regressor, problem.torque
    parameters: Floats = np.asarray(np.linalg.lstsq(regressor, torque, rcond=None)[0], np.float64)
    if problem.links:
        start = np.zeros(len(problem.links.base.columns))
        parameters = possible_links.step(problem.links, regressor.T @ regressor, regressor.T @ torque, start)
    objective = float(np.sum((problem.torque - problem.regressor @ parameters) ** 2))
    progress(1, 1)
    return Estimate(
        parameters, objective, np.array([objective]), diagnostics={"bound_to_bodies": bool(problem.links)}
    )
