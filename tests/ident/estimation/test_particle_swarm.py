"""The common part of the particle swarms."""

from typing import Any

import numpy as np

from ident.estimation.particle_swarm import Settings, Swarm, search
from ident.estimation.problem import Problem
from recordings.recording import Floats

TRUTH = np.array([1.0, -2.0, 3.0, 0.5])


def problem() -> Problem:
    rng = np.random.default_rng(0)
    regressor = rng.normal(size=(200, 4))
    bounds = np.tile([-10.0, 10.0], (4, 1))
    return Problem(regressor, regressor @ TRUTH + 0.1 * rng.normal(size=200), bounds)


def best(swarm: Swarm) -> Floats:
    """Every particle follows the best one."""
    return swarm.personal[[swarm.personal_value.argmin()] * len(swarm.current)]


def test_search_reaches_the_certified_minimum_and_stops_and_its_progress_gives_the_excess() -> None:
    steps: list[tuple[Any, ...]] = []
    settings = Settings(particles=30, iterations=500)
    result = search(problem(), np.random.default_rng(0), lambda *step: steps.append(step), settings, best)
    assert result.certificate is not None
    excesses = [result.certificate.excess(objective) for objective in result.history[1:]]
    assert steps == [(done, 500, excess) for done, excess in enumerate(excesses, start=1)]
    assert result.certificate.excess(result.objective) <= 1e-8
    np.testing.assert_allclose(result.parameters, result.certificate.parameters, atol=1e-5)
    assert result.diagnostics["iterations"] == len(result.history) - 1 < 500
