"""Closed-form estimators against independent implementations."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import lstsq, pinv
from scipy.optimize import lsq_linear

from ident import plugins
from ident.estimation import estimators
from ident.estimation.problem import Estimate, Problem
from recordings.errors import BadInput
from recordings.recording import Floats

BOUNDS = np.tile([-50.0, 50.0], (6, 1))


def problem(*, alike: float = 0.1) -> Problem:
    """400 rows, 6 columns of different sizes, the last two `alike`, and a torque that is noisy in one half."""
    rng = np.random.default_rng(3)
    regressor = rng.normal(size=(400, 6)) * np.geomspace(0.2, 20, 6)
    regressor[:, 5] = regressor[:, 4] + alike * rng.normal(size=400)
    deviation = np.repeat([0.1, 1.0], 200)
    torque = regressor @ rng.normal(size=6) + deviation * rng.normal(size=400)
    return Problem(regressor, torque, BOUNDS, deviation)


def solve(name: str, given: Problem, **settings: Any) -> Estimate:
    module = estimators.load(name)
    generator = np.random.default_rng(0)
    return module.estimate(given, generator, lambda *_: None, estimators.settings(name, settings))


def augmented(given: Problem, damping: float) -> Floats:
    """Least squares with a penalty damping^2 |theta|^2, as more rows."""
    k = given.regressor.shape[1]
    rows = np.vstack([given.regressor, damping * np.eye(k)])
    solution: Floats = lstsq(rows, np.concatenate([given.torque, np.zeros(k)]))[0]
    return solution


def test_plain_least_squares() -> None:
    given = problem()
    found = solve("ls", given)
    expected = lsq_linear(given.regressor, given.torque, tol=1e-14)
    np.testing.assert_allclose(found.parameters, expected.x, rtol=1e-9)
    assert found.objective == pytest.approx(2 * expected.cost)


def test_weighted_least_squares_is_better_where_noise_differs() -> None:
    given = problem()
    assert given.deviation is not None
    found = solve("wls", given)
    information = np.linalg.inv(given.regressor.T @ np.diag(given.deviation**-2) @ given.regressor)
    expected = information @ given.regressor.T @ (given.torque / given.deviation**2)
    np.testing.assert_allclose(found.parameters, expected, rtol=1e-6)
    assert not np.allclose(found.parameters, solve("ls", given).parameters, rtol=1e-3)
    assert found.objective == pytest.approx(400, rel=0.2)


@pytest.mark.parametrize("damping", [0.0, 1e-3, 0.1])
def test_damped_least_squares(damping: float) -> None:
    given = problem()
    expected = augmented(given, damping * np.linalg.norm(given.regressor, 2))
    np.testing.assert_allclose(solve("dls", given, damping=damping).parameters, expected, rtol=1e-8)


@pytest.mark.parametrize("threshold", [1e-6, 0.01, 0.5])
def test_truncated_singular_values(threshold: float) -> None:
    given = problem(alike=0.02)
    found = solve("svd", given, threshold=threshold)
    length = np.linalg.norm(given.regressor, axis=0)
    inverse, rank = pinv(given.regressor / length, rtol=threshold, return_rank=True)
    np.testing.assert_allclose(found.parameters, inverse @ given.torque / length, rtol=1e-8)
    assert found.diagnostics["rank"] == rank == {1e-6: 6, 0.01: 5, 0.5: 5}[threshold]


def test_two_equal_columns_share_what_belongs_to_both() -> None:
    found = solve("svd", problem(alike=0.0))
    assert found.diagnostics["rank"] == 5
    assert found.parameters[4] == pytest.approx(found.parameters[5])


@pytest.mark.parametrize("covariance", [1e6, 0.01])
def test_recursive_least_squares_is_the_batch_solution(covariance: float) -> None:
    given = problem()
    expected = augmented(given, covariance**-0.5)
    np.testing.assert_allclose(solve("rls", given, covariance=covariance).parameters, expected, rtol=1e-6)


def test_recursive_least_squares_step_by_step() -> None:
    """The recursion in matrix form, three rows of an instant at a time, as Islam and Bernstein print it."""
    given = problem()
    P, theta = 1e3 * np.eye(6), np.zeros(6)
    for first in range(0, 399, 3):
        phi, y = given.regressor[first : first + 3], given.torque[first : first + 3]
        P = P - P @ phi.T @ np.linalg.inv(np.eye(3) + phi @ P @ phi.T) @ phi @ P
        theta = theta + P @ phi.T @ (y - phi @ theta)
    cut = Problem(given.regressor[:399], given.torque[:399], BOUNDS)
    np.testing.assert_allclose(solve("rls", cut, covariance=1e3).parameters, theta, rtol=1e-7)


def test_exact_least_absolute_deviations(
    least_absolute_deviations: Callable[[Floats, Floats, Floats], tuple[Floats, float]],
) -> None:
    given = problem()
    found = solve("lad", given)
    parameters, minimum = least_absolute_deviations(given.regressor, given.torque, given.bounds)
    assert found.objective == pytest.approx(minimum, rel=1e-10)
    np.testing.assert_allclose(found.parameters, parameters, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "setting", "value"),
    [("dls", "damping", -1.0), ("svd", "threshold", 1.0), ("rls", "covariance", 0.0), ("dls", "damping", np.nan)],
)
def test_impossible_settings_are_refused(name: str, setting: str, value: float) -> None:
    assert name in plugins.names("estimators")
    with pytest.raises(BadInput, match="expected"):
        estimators.settings(name, {setting: value})
