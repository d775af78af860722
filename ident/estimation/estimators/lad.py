"""Exact least absolute deviations: the minimum of objective (33), which a swarm can at best reach.

The search region is the swarm's. See `ident.estimation.lad_certificate`, which proves the minimum too.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.lad_certificate import certify
from ident.estimation.problem import Estimate, Problem, Progress


@dataclass(frozen=True)
class Settings:
    """None."""


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """The certified minimiser itself."""
    certificate = certify(problem.regressor, problem.torque, problem.bounds)
    progress(1, 1)
    return Estimate(certificate.parameters, certificate.objective, np.array([certificate.objective]), certificate)
