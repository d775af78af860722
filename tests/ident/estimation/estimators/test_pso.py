from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.estimation.estimators import pso, pso_classic
from ident.estimation.particle_swarm import Swarm
from ident.estimation.problem import Estimate, Problem
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
def test_the_swarm_reaches_the_exact_minimum(neighbourhood: str, least_absolute_deviations: LinearProgram) -> None:
    result = estimate(pso.Settings(neighbourhood=neighbourhood, tolerance=0.0))  # type: ignore[arg-type]
    parameters, minimum = least_absolute_deviations(*problem(), BOUNDS)
    assert minimum * (1 - 1e-12) <= result.objective <= minimum * (1 + 1e-6)
    np.testing.assert_allclose(result.parameters, parameters, atol=1e-2)


def test_a_minimum_on_the_edge_of_the_region_is_reached(least_absolute_deviations: LinearProgram) -> None:
    bounds = BOUNDS.copy()
    unconstrained, _ = least_absolute_deviations(*problem(), BOUNDS)
    bounds[3] = unconstrained[3] + 0.2, unconstrained[3] + 5
    bounds[7] = unconstrained[7] - 5, unconstrained[7] - 0.1
    result = estimate(pso.Settings(iterations=500, tolerance=0.0), bounds)
    _, minimum = least_absolute_deviations(*problem(), bounds)
    assert result.objective <= minimum * (1 + 1e-6)
    np.testing.assert_allclose(result.parameters[[3, 7]], [bounds[3, 0], bounds[7, 1]], rtol=1e-9)


def test_the_classical_swarm_nearly_reaches_the_minimum(least_absolute_deviations: LinearProgram) -> None:
    """It does not reach the minimum, as it contracts too early (Remark 1)."""
    data = Problem(*problem(), BOUNDS)
    result = pso_classic.estimate(data, np.random.default_rng(1), lambda *_: None, pso_classic.Settings())
    _, minimum = least_absolute_deviations(*problem(), BOUNDS)
    assert minimum * (1 - 1e-12) <= result.objective <= minimum * (1 + 1e-4)
    cyclic = estimate(pso.Settings())
    assert cyclic.objective < result.objective


def test_a_swarm_that_diverges_stays_finite() -> None:
    """Without limit, its positions would overflow after some hundred steps, with warnings."""
    result = estimate(pso.Settings(particles=20, neighbours=4, inertia=1.0, cognitive=9.0, social=9.0))
    assert np.isfinite(result.parameters).all()


def test_results_depend_on_draws_neighbourhood_and_seed() -> None:
    brief: dict[str, Any] = {"particles": 20, "neighbours": 4, "iterations": 10}
    objectives = [
        estimate(pso.Settings(**brief, draws="particle")).objective,
        estimate(pso.Settings(**brief, draws="dimension")).objective,
        estimate(pso.Settings(**brief, neighbourhood="current")).objective,
        estimate(pso.Settings(**brief, neighbourhood="personal")).objective,
        estimate(pso.Settings(**brief), seed=2).objective,
    ]
    assert len(set(objectives)) == 4  # the default is among both pairs


@given(st.lists(st.floats(-9, 9), min_size=9, max_size=20, unique=True), st.sampled_from([0, 2, 4, 8]))
def test_the_best_neighbour_is_taken_from_a_ring_of_indices(values: list[float], neighbours: int) -> None:
    n, half = len(values), neighbours // 2
    value = np.array(values)
    swarm = Swarm(current=value[:, None], value=value, personal=-value[:, None], personal_value=value)
    leaders = pso.topology(pso.Settings(particles=n, neighbours=neighbours))(swarm)
    for i in range(n):
        assert leaders[i, 0] == min(values[(i + shift) % n] for shift in range(-half, half + 1))
