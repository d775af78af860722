"""Weighted least squares on the mechanism's own model, the 11 parameters of (30).

Not in the paper. The voltage is noisy, so torque samples differ in precision (`ident.data.noise`); each residual is
divided by its standard deviation. The search region is ignored.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.problem import Estimate, Problem, Progress
from recordings.recording import Floats

WEIGHTED = True


@dataclass(frozen=True)
class Settings:
    """No settings."""


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals, each divided by its variance."""
    assert problem.deviation is not None
    regressor, torque = problem.regressor / problem.deviation[:, None], problem.torque / problem.deviation
    parameters: Floats = np.asarray(np.linalg.lstsq(regressor, torque, rcond=None)[0], np.float64)
    objective = float(np.sum((torque - regressor @ parameters) ** 2))
    progress(1, 1)
    return Estimate(parameters, objective, np.array([objective]))
