"""Particle swarm optimisation of objective (33): the common part of the cyclic and the classical swarm."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from ident.estimation.l1_objective import L1Objective
from ident.estimation.lad_certificate import certify
from ident.estimation.problem import Estimate, Problem, Progress
from recordings.errors import BadInput
from recordings.recording import Floats

Leaders = Callable[["Swarm"], Floats]
"""Positions (n, k) that attract the particles besides their personal best positions."""


@dataclass(frozen=True)
class Settings:
    """Settings of any swarm. Defaults are those of the paper, except `tolerance`."""

    particles: int = 300
    """N_p."""
    iterations: int = 1000
    inertia: float = 0.72984
    """c_0."""
    cognitive: float = 1.49618
    """c_1."""
    social: float = 1.49618
    """c_2."""
    tolerance: float = 1e-8
    """Relative excess over the certified minimum at which the search stops; 0: never stop early, as in the paper."""

    def __post_init__(self) -> None:
        if self.particles < 2:
            raise BadInput(f"at least two particles expected, {self.particles} found; give a larger number")
        if self.iterations < 1:
            raise BadInput(f"at least one iteration expected, {self.iterations} found; give a larger number")
        if not 0 <= self.tolerance < 1:
            raise BadInput(f"a tolerance from 0 to below 1 expected, {self.tolerance:g} found; change it")


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


def search(
    problem: Problem, generator: Generator, progress: Progress, settings: Settings, leaders: Leaders
) -> Estimate:
    """Minimise (33) within the search region of `problem` by a swarm, Eqs. (34)-(35), (A14)-(A15).

    leaders: the topology of the swarm.

    r1, r2 are one number per particle and step, as printed. Particles start in the region and may leave it, since
    (34)-(35) do not prevent it. The objective is then evaluated at the nearest point of the region, and that point is
    stored.
    """
    certificate = certify(problem.regressor, problem.torque, problem.bounds)
    objective = L1Objective(problem.regressor, problem.torque)
    lowest, highest = problem.bounds.T
    shape = (settings.particles, len(lowest))

    position = generator.uniform(lowest, highest, shape)
    velocity = np.zeros(shape)
    value = objective(position)
    swarm = Swarm(position, value, position, value)  # (31)
    history = [value.min()]
    for step in range(settings.iterations):
        r1, r2 = generator.random((2, settings.particles, 1))
        velocity = (
            settings.inertia * velocity
            + settings.cognitive * r1 * (swarm.personal - position)
            + settings.social * r2 * (leaders(swarm) - position)
        )  # (34)
        position = position + velocity  # (35)
        _update(swarm, np.clip(position, lowest, highest), objective)
        history.append(swarm.personal_value.min())
        excess = certificate.excess(history[-1])
        progress(step + 1, settings.iterations, excess)
        if settings.tolerance and excess <= settings.tolerance:
            break
    best = int(swarm.personal_value.argmin())
    return Estimate(
        swarm.personal[best],
        float(history[-1]),
        np.array(history),
        certificate,
        diagnostics={"iterations": len(history) - 1},
    )


def _update(swarm: Swarm, current: Floats, objective: Callable[[Floats], Floats]) -> None:
    swarm.current, swarm.value = current, objective(current)
    better = swarm.value < swarm.personal_value
    swarm.personal = np.where(better[:, None], current, swarm.personal)
    swarm.personal_value = np.where(better, swarm.value, swarm.personal_value)
