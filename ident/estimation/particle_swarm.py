"""Particle swarm optimisation of objective (33): the common part of the cyclic and the classical swarm."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.random import Generator

from ident.estimation.l1_objective import L1Objective
from ident.estimation.lad_certificate import certify
from ident.estimation.problem import Estimate, Problem, Progress
from ident.estimation.settings import Meaning
from recordings.recording import Floats

Leaders = Callable[["Swarm"], Floats]
"""Positions (n, k) that attract the particles besides their personal best positions."""


_MOST_PARTICLES = 100_000
"""Limit of memory."""
_FAR = 1e6
"""Widths of the search region beyond which no particle flies, so that a swarm that diverges does not overflow."""


Particles = Annotated[int, Meaning("size of the swarm", "N_p", least=2, most=_MOST_PARTICLES)]
Iterations = Annotated[int, Meaning("largest number of steps", least=1)]
Draws = Annotated[
    Literal["particle", "dimension"],
    Meaning("whether r1 and r2 are drawn once for a particle, as printed, or for each of its dimensions"),
]


@dataclass(frozen=True)
class Settings:
    """Settings of any swarm. Defaults are those of the paper, except `tolerance`."""

    particles: Particles = 300
    iterations: Iterations = 1000
    inertia: Annotated[float, Meaning("share of its velocity that a particle keeps", "c0", least=0, most=1)] = 0.72984
    cognitive: Annotated[
        float, Meaning("attraction by the best position of the particle itself", "c1", least=0, most=_FAR)
    ] = 1.49618
    social: Annotated[
        float, Meaning("attraction by the best neighbour, or the best of the swarm", "c2", least=0, most=_FAR)
    ] = 1.49618
    draws: Draws = "particle"
    tolerance: Annotated[
        float,
        Meaning(
            "relative excess over the certified minimum at which the search stops; 0: never, as printed",
            least=0,
            below=1,
        ),
    ] = 1e-8


@dataclass
class Swarm:
    """State of n particles at one step."""

    current: Floats
    """(n, k) positions, clipped to the search region."""
    value: Floats
    """(n,) objective at the current positions."""
    personal: Floats
    """(n, k) best position of each particle so far."""
    personal_value: Floats
    """(n,) objective at the personal best positions."""

    @property
    def best(self) -> Floats:
        """(k,) best position so far."""
        return self.personal[self.personal_value.argmin()]


def flight(
    objective: Callable[[Floats], Floats], bounds: Floats, generator: Generator, settings: Settings, leaders: Leaders
) -> Iterator[Swarm]:
    """Yield the swarm as it is initialised, (31), and after each step, Eqs. (34)-(35), (A14)-(A15).

    objective: values (n,) at positions (n, k). bounds: (k, 2) search region. leaders: the topology of the swarm.

    r1, r2 are one number per particle and step, as printed, unless the settings say otherwise. Particles start in the
    region and may leave it, since (34)-(35) do not prevent it. The objective is then evaluated at the nearest point
    of the region, and that point is stored.
    """
    lowest, highest = bounds.T
    margin = _FAR * (highest - lowest)
    shape = (settings.particles, len(bounds))
    draws = shape if settings.draws == "dimension" else (settings.particles, 1)
    position = generator.uniform(lowest, highest, shape)
    velocity = np.zeros(shape)
    value = objective(position)
    swarm = Swarm(position, value, position, value)  # (31)
    yield swarm
    for _ in range(settings.iterations):
        r1, r2 = generator.random((2, *draws))
        velocity = (
            settings.inertia * velocity
            + settings.cognitive * r1 * (swarm.personal - position)
            + settings.social * r2 * (leaders(swarm) - position)
        )  # (34)
        position = np.clip(position + velocity, lowest - margin, highest + margin)  # (35)
        _update(swarm, np.clip(position, lowest, highest), objective)
        yield swarm


def search(
    problem: Problem, generator: Generator, progress: Progress, settings: Settings, leaders: Leaders
) -> Estimate:
    """Minimise (33) within the search region of `problem` by a swarm with the topology `leaders`."""
    certificate = certify(problem.regressor, problem.torque, problem.bounds)
    objective = L1Objective(problem.regressor, problem.torque)
    even = np.ptp(problem.bounds, axis=1) / np.sqrt(12.0)
    history: list[float] = []
    spread: list[float] = []
    for step, swarm in enumerate(flight(objective, problem.bounds, generator, settings, leaders)):
        history.append(float(swarm.personal_value.min()))
        spread.append(float(np.mean(swarm.current.std(axis=0) / even)))
        excess = certificate.excess(history[-1])
        if step:
            progress(step, settings.iterations, excess)
            if settings.tolerance and excess <= settings.tolerance:
                break
    return Estimate(
        swarm.best,
        history[-1],
        np.array(history),
        certificate,
        np.array(spread),
        diagnostics={"iterations": len(history) - 1},
    )


def _update(swarm: Swarm, current: Floats, objective: Callable[[Floats], Floats]) -> None:
    swarm.current, swarm.value = current, objective(current)
    better = swarm.value < swarm.personal_value
    swarm.personal = np.where(better[:, None], current, swarm.personal)
    swarm.personal_value = np.where(better, swarm.value, swarm.personal_value)
