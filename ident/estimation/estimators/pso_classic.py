"""Classical particle swarm, Appendix C, Eqs. (A13)-(A15), on the objective (33).

Every particle is attracted by the best position of the whole swarm. Appendix C prints no settings; those of the
cyclic swarm are used, so that the two differ only in the neighbourhood.
"""

from numpy.random import Generator

from ident.estimation import particle_swarm
from ident.estimation.particle_swarm import Settings
from ident.estimation.problem import Estimate, Problem, Progress

__all__ = ["Settings", "estimate"]


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Search with the whole swarm as the neighbourhood of each particle."""
    return particle_swarm.search(problem, generator, progress, settings, lambda swarm: swarm.best)
