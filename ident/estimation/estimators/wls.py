"""Weighted least squares on the mechanism's own model, the 11 parameters of (30).

Not in the paper. The voltage is noisy, so torque samples differ in precision (`ident.data.noise`); each residual is
divided by its standard deviation. The search region is ignored, but links that shall be bodies are.
"""

from dataclasses import replace

from numpy.random import Generator

from ident.estimation.estimators import ls
from ident.estimation.estimators.ls import Settings
from ident.estimation.problem import Estimate, Problem, Progress

__all__ = ["WEIGHTED", "Settings", "estimate"]
WEIGHTED = True


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Minimise the sum of squared residuals, each divided by its variance."""
    assert problem.deviation is not None
    regressor, torque = problem.regressor / problem.deviation[:, None], problem.torque / problem.deviation
    return ls.estimate(replace(problem, regressor=regressor, torque=torque), generator, progress, settings)
