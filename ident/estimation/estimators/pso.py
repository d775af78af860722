"""Particle swarm with a cyclic neighbourhood, Section 3, Steps 0-2, Eqs. (31)-(35), on the objective (33).

Readings of the printed text:

- The neighbours of a particle are the N_s / 2 before and after it on a ring of indices, and itself.
- Their best is either their best current position, as (32) and Step 2 print it ("current"), or their best personal
  best, the usual form ("personal"). Measured with the paper's settings on four noisy data sets, eight seeds each, the
  objective ended above its exact minimum by (median of each set) 0 to 7e-10 with "current" and 3e-12 to 9e-9 with
  "personal", relative; so "current" is the default.
- The update of the personal best in Step 2 runs to l; l + 1 is meant, or a new position would count a step late.
- Step 1 ends after a number of iterations. We also end where the certified minimum is reached (`tolerance`).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator

from ident.estimation import particle_swarm
from ident.estimation.particle_swarm import Swarm
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput
from recordings.recording import Floats, Ints


@dataclass(frozen=True)
class Settings(particle_swarm.Settings):
    """Settings of the swarm; defaults are the paper's."""

    neighbours: int = 60
    """N_s, even and below N_p."""
    neighbourhood: Literal["current", "personal"] = "current"
    """Whether the best neighbour is the one with the best current position or with the best personal best."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.neighbours % 2 or not 0 <= self.neighbours < self.particles:
            raise BadInput(
                f"an even number of neighbours below {self.particles} expected, {self.neighbours} found; change it"
            )


def estimate(problem: Problem, generator: Generator, progress: Progress, settings: Settings) -> Estimate:
    """Search with N_s neighbours by index."""

    def best_neighbours(now: Swarm) -> Floats:  # (32)
        if settings.neighbourhood == "personal":
            return now.personal[_best_neighbour(now.personal_value, settings.neighbours)]
        return now.current[_best_neighbour(now.value, settings.neighbours)]

    return particle_swarm.search(problem, generator, progress, settings, best_neighbours)


def _best_neighbour(value: Floats, neighbours: int) -> Ints:
    """Index (n,) of the best of `value` (n,) among each particle's neighbours on the ring, itself included."""
    n, half = len(value), neighbours // 2
    ring = np.arange(-half, n + half) % n
    window = sliding_window_view(value[ring], neighbours + 1)
    best: Ints = ring[np.arange(n) + window.argmin(axis=1)]
    return best
