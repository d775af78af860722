"""Classical particle swarm, Appendix C, Eqs. (A13)-(A15), on the objective (33).

Every particle is drawn to the best position that any of the swarm has found. Appendix C prints no settings; the
cyclic swarm's are used, so that the two differ in nothing but the neighbourhood.
"""

import numpy as np
from numpy.random import Generator

from ident.estimation import particle_swarm
from ident.estimation.particle_swarm import Settings, Swarm
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.recording import Floats

__all__ = ["Settings", "estimate"]


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Search with the whole swarm as everybody's neighbourhood."""
    return particle_swarm.search(problem, generator, progress, settings, _best_of_all)


def _best_of_all(now: Swarm) -> Floats:
    best: Floats = now.personal[np.argmin(now.personal_value)]
    return best
