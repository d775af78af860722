"""The common part of the particle swarms."""

import numpy as np
import pytest

from ident.estimation.particle_swarm import Settings, Swarm, search
from ident.estimation.problem import Problem
from recordings.errors import BadInput
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


def test_search_reaches_the_certified_minimum_and_stops() -> None:
    settings = Settings(particles=30, iterations=500)
    result = search(problem(), np.random.default_rng(0), lambda *_: None, settings, best)
    assert result.certificate is not None
    assert result.certificate.excess(result.objective) <= 1e-8
    np.testing.assert_allclose(result.parameters, result.certificate.parameters, atol=1e-5)
    assert result.diagnostics["iterations"] == len(result.history) - 1 < 500


def test_progress_counts_steps_and_gives_the_excess() -> None:
    calls: list[tuple[int, int, float | None]] = []
    search(
        problem(),
        np.random.default_rng(0),
        lambda done, total, excess=None: calls.append((done, total, excess)),
        Settings(particles=5, iterations=4, tolerance=0.0),
        best,
    )
    assert [call[:2] for call in calls] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert all(excess is not None and excess >= 0 for _, _, excess in calls)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"particles": 1}, "2 to 100000 particles expected, 1 found"),
        ({"iterations": 0}, "at least one iteration expected, 0 found"),
        ({"tolerance": 1.0}, "tolerance from 0 to below 1 expected, 1 found"),
    ],
)
def test_impossible_settings_are_refused(changed: dict[str, float], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        Settings(**changed)  # type: ignore[arg-type]
