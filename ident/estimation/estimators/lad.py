"""Exact least absolute deviations: the minimum of objective (33), the best result that a swarm can reach.

The search region is that of the swarm. `ident.estimation.lad_certificate` also certifies the minimum.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.lad_certificate import certify
from ident.estimation.problem import Estimate, Problem, Progress


@dataclass(frozen=True)
class Settings:
    """No settings."""


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Return the certified minimiser."""
    certificate = certify(problem.regressor, problem.torque, problem.bounds)
    progress(1, 1)
    return Estimate(certificate.parameters, certificate.objective, np.array([certificate.objective]), certificate)
