from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.estimation.estimators import pso, pso_classic
from ident.estimation.problem import Estimate, Problem
from recordings.errors import BadInput
from recordings.recording import Floats

LinearProgram = Callable[[Floats, Floats, Floats], tuple[Floats, float]]
BOUNDS = np.tile([-20.0, 20.0], (11, 1))


def problem(m: int = 900) -> tuple[Floats, Floats]:
    """A regressor (m, 11) with columns of different sizes, some of them alike, and a noisy torque (m,)."""
    rng = np.random.default_rng(0)
    regressor = rng.normal(size=(m, 11)) @ (np.eye(11) + 0.3 * rng.normal(size=(11, 11)))
    regressor *= np.geomspace(0.5, 5, 11)
    return regressor, regressor @ rng.normal(size=11) + rng.laplace(size=m)


def estimate(settings: pso.Settings, bounds: Floats = BOUNDS, seed: int = 1) -> Estimate:
    return pso.estimate(Problem(*problem(), bounds), np.random.default_rng(seed), lambda *_: None, settings)


@pytest.mark.parametrize("neighbourhood", ["current", "personal"])
def test_reaches_the_exact_minimum(neighbourhood: str, least_absolute_deviations: LinearProgram) -> None:
    found = estimate(pso.Settings(neighbourhood=neighbourhood, tolerance=0.0))  # type: ignore[arg-type]
    parameters, minimum = least_absolute_deviations(*problem(), BOUNDS)
    assert minimum * (1 - 1e-12) <= found.objective <= minimum * (1 + 1e-6)
    np.testing.assert_allclose(found.parameters, parameters, atol=1e-2)


def test_a_minimum_on_the_edge_of_the_region_is_reached(least_absolute_deviations: LinearProgram) -> None:
    bounds = BOUNDS.copy()
    free, _ = least_absolute_deviations(*problem(), BOUNDS)
    bounds[3] = free[3] + 0.2, free[3] + 5
    bounds[7] = free[7] - 5, free[7] - 0.1
    found = estimate(pso.Settings(iterations=500, tolerance=0.0), bounds)
    _, minimum = least_absolute_deviations(*problem(), bounds)
    assert found.objective <= minimum * (1 + 1e-6)
    np.testing.assert_allclose(found.parameters[[3, 7]], [bounds[3, 0], bounds[7, 1]], rtol=1e-9)


def test_the_classical_swarm_comes_near(least_absolute_deviations: LinearProgram) -> None:
    """But not to the minimum: it contracts too early (Remark 1)."""
    given = Problem(*problem(), BOUNDS)
    found = pso_classic.estimate(given, np.random.default_rng(1), lambda *_: None, pso_classic.Settings())
    _, minimum = least_absolute_deviations(*problem(), BOUNDS)
    assert minimum * (1 - 1e-12) <= found.objective <= minimum * (1 + 1e-4)
    cyclic = estimate(pso.Settings())
    assert cyclic.objective < found.objective


def test_stops_at_the_tolerance_and_not_before() -> None:
    found = estimate(pso.Settings(tolerance=1e-4))
    assert found.certificate is not None
    excess = [found.certificate.excess(value) for value in found.history]
    assert excess[-1] <= 1e-4 < excess[-2]
    assert found.diagnostics["iterations"] == len(found.history) - 1 < 1000


def test_without_tolerance_all_iterations_are_run() -> None:
    found = estimate(pso.Settings(tolerance=0.0, iterations=600))
    assert len(found.history) == 601


def test_the_region_is_never_left() -> None:
    bounds = np.tile([0.5, 0.6], (11, 1))
    found = estimate(pso.Settings(iterations=50), bounds)
    assert ((found.parameters >= 0.5) & (found.parameters <= 0.6)).all()


def test_the_two_neighbourhoods_and_other_seeds_are_other_searches() -> None:
    brief = {"particles": 20, "neighbours": 4, "iterations": 10}
    ends = [
        estimate(pso.Settings(**brief, neighbourhood="current")).objective,  # type: ignore[arg-type]
        estimate(pso.Settings(**brief, neighbourhood="personal")).objective,  # type: ignore[arg-type]
        estimate(pso.Settings(**brief, neighbourhood="current"), seed=2).objective,  # type: ignore[arg-type]
    ]
    assert len(set(ends)) == 3


def test_settings_are_the_papers() -> None:
    settings = pso.Settings()
    assert settings.tolerance  # stops early, unlike the paper
    assert (settings.inertia, settings.cognitive, settings.social) == (0.72984, 1.49618, 1.49618)
    assert (settings.particles, settings.neighbours, settings.iterations) == (300, 60, 1000)


@given(st.lists(st.floats(-9, 9), min_size=9, max_size=20, unique=True), st.sampled_from([0, 2, 4, 8]))
def test_the_best_neighbour_is_sought_on_a_ring_of_indices(values: list[float], neighbours: int) -> None:
    n, half = len(values), neighbours // 2
    found = pso._best_neighbour(np.array(values), neighbours)
    for i in range(n):
        around = [(i + shift) % n for shift in range(-half, half + 1)]
        assert found[i] == min(around, key=lambda j: values[j])


@pytest.mark.parametrize(
    "wrong",
    [
        {"neighbours": 7},
        {"neighbours": 300},
        {"neighbours": -2},
        {"iterations": 0},
        {"particles": 1, "neighbours": 0},
        {"tolerance": -1},
    ],
)
def test_impossible_settings_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(BadInput, match="expected"):
        pso.Settings(**wrong)  # type: ignore[arg-type]


def test_progress_is_told_at_every_step() -> None:
    told: list[tuple[Any, ...]] = []
    settings = pso.Settings(iterations=5)
    given = Problem(*problem(), BOUNDS)
    found = pso.estimate(given, np.random.default_rng(0), lambda *step: told.append(step), settings)
    assert found.certificate
    excess = [found.certificate.excess(value) for value in found.history]
    assert told == [(i, 5, excess[i]) for i in range(1, 6)]
