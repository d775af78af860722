"""Particle swarm with a cyclic neighbourhood, Section 3, Steps 0-2, Eqs. (31)-(35), on the objective (33).

Readings of the printed text:

- r1, r2 are one number per particle and step, as printed.
- The neighbours of a particle are the N_s / 2 before and after it on a ring of indices, and itself.
- Their best is either their best current position, as (32) and Step 2 print it ("current"), or their best personal
  best, the usual form ("personal"). Measured with the paper's settings on four noisy data sets, eight seeds each, the
  objective ended above its exact minimum by (median of each set) 0 to 7e-10 with "current" and 3e-12 to 9e-9 with
  "personal", relative; so "current" is the default.
- The update of the personal best in Step 2 runs to l; l + 1 is meant, or a new position would count a step late.

The search region: particles start in it and may leave it, as nothing in (34)-(35) keeps them; the objective is then
taken at the nearest point of the region, and it is that point which is remembered.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.random import Generator

from ident.estimators import Estimate, Progress
from ident.l1_kernel import L1Objective
from recordings.errors import BadInput
from recordings.recording import Floats, Ints


@dataclass(frozen=True)
class Settings:
    """Settings of the swarm; defaults are the paper's."""

    particles: int = 300
    """N_p."""
    neighbours: int = 60
    """N_s, even and below N_p."""
    iterations: int = 1000
    inertia: float = 0.72984
    """c_0."""
    cognitive: float = 1.49618
    """c_1."""
    social: float = 1.49618
    """c_2."""
    neighbourhood: Literal["current", "personal"] = "current"
    """Whether the best neighbour is the one with the best current position or with the best personal best."""

    def __post_init__(self) -> None:
        if self.neighbours % 2 or not 0 <= self.neighbours < self.particles:
            raise BadInput(
                f"an even number of neighbours below {self.particles} expected, {self.neighbours} found; change it"
            )
        if self.iterations < 1:
            raise BadInput(f"at least one iteration expected, {self.iterations} found; give a larger number")


def estimate(
    regressor: Floats, torque: Floats, bounds: Floats, generator: Generator, progress: Progress, settings: Settings
) -> Estimate:
    """Fit torque (m,) [N m] by regressor (m, k) times parameters within bounds (k, 2) [lowest, highest]."""
    objective = L1Objective(regressor, torque)
    lowest, highest = bounds.T
    shape = (settings.particles, len(bounds))

    position = generator.uniform(lowest, highest, shape)
    velocity = np.zeros(shape)
    personal, personal_value = position, objective(position)  # (31)
    social = personal[_best_neighbour(personal_value, settings.neighbours)]  # (32)
    history = [personal_value.min()]
    for step in range(settings.iterations):
        r1, r2 = generator.random((2, settings.particles, 1))
        velocity = (
            settings.inertia * velocity
            + settings.cognitive * r1 * (personal - position)
            + settings.social * r2 * (social - position)
        )  # (34)
        position = position + velocity  # (35)
        current = np.clip(position, lowest, highest)
        value = objective(current)
        better = value < personal_value
        personal = np.where(better[:, None], current, personal)
        personal_value = np.where(better, value, personal_value)
        if settings.neighbourhood == "personal":
            social = personal[_best_neighbour(personal_value, settings.neighbours)]
        else:
            social = current[_best_neighbour(value, settings.neighbours)]
        history.append(personal_value.min())
        progress(step + 1, settings.iterations)
    best = int(personal_value.argmin())
    return Estimate(personal[best], float(personal_value[best]), np.array(history))


def _best_neighbour(value: Floats, neighbours: int) -> Ints:
    """Index (n,) of the best of `value` (n,) among each particle's neighbours on the ring, itself included."""
    n, half = len(value), neighbours // 2
    ring = np.arange(-half, n + half) % n
    window = sliding_window_view(value[ring], neighbours + 1)
    best: Ints = ring[np.arange(n) + window.argmin(axis=1)]
    return best
