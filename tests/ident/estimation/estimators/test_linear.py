"""Closed-form estimators against independent implementations."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import lstsq, pinv
from scipy.optimize import lsq_linear

from ident.estimation import estimators
from ident.estimation.problem import Estimate, Problem
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


def solve(name: str, data: Problem, **settings: Any) -> Estimate:
    module = estimators.load(name)
    generator = np.random.default_rng(0)
    return module.estimate(data, generator, lambda *_: None, estimators.settings(name, settings))


def augmented(data: Problem, damping: float) -> Floats:
    """Least squares with a penalty damping^2 |theta|^2, as additional rows."""
    k = data.regressor.shape[1]
    rows = np.vstack([data.regressor, damping * np.eye(k)])
    solution: Floats = lstsq(rows, np.concatenate([data.torque, np.zeros(k)]))[0]
    return solution


def test_least_squares_matches_an_independent_solver() -> None:
    data = problem()
    result = solve("ls", data)
    expected = lsq_linear(data.regressor, data.torque, tol=1e-14)
    np.testing.assert_allclose(result.parameters, expected.x, rtol=1e-9)
    assert result.objective == pytest.approx(2 * expected.cost)


def test_weighted_least_squares_uses_the_standard_deviation_of_each_row() -> None:
    data = problem()
    assert data.deviation is not None
    result = solve("wls", data)
    information = np.linalg.inv(data.regressor.T @ np.diag(data.deviation**-2) @ data.regressor)
    expected = information @ data.regressor.T @ (data.torque / data.deviation**2)
    np.testing.assert_allclose(result.parameters, expected, rtol=1e-6)
    assert not np.allclose(result.parameters, solve("ls", data).parameters, rtol=1e-3)
    assert result.objective == pytest.approx(400, rel=0.2)


@pytest.mark.parametrize("damping", [0.0, 1e-3, 0.1])
def test_damped_least_squares_is_ridge_regression(damping: float) -> None:
    data = problem()
    expected = augmented(data, damping * np.linalg.norm(data.regressor, 2))
    np.testing.assert_allclose(solve("dls", data, damping=damping).parameters, expected, rtol=1e-8)


@pytest.mark.parametrize("threshold", [1e-6, 0.01, 0.5])
def test_truncated_svd_is_the_pseudoinverse_with_threshold(threshold: float) -> None:
    data = problem(alike=0.02)
    result = solve("svd", data, threshold=threshold)
    length = np.linalg.norm(data.regressor, axis=0)
    inverse, rank = pinv(data.regressor / length, rtol=threshold, return_rank=True)
    np.testing.assert_allclose(result.parameters, inverse @ data.torque / length, rtol=1e-8)
    assert result.diagnostics["rank"] == rank == {1e-6: 6, 0.01: 5, 0.5: 5}[threshold]


def test_two_equal_columns_get_equal_parameters() -> None:
    result = solve("svd", problem(alike=0.0))
    assert result.diagnostics["rank"] == 5
    assert result.parameters[4] == pytest.approx(result.parameters[5])


@pytest.mark.parametrize("covariance", [1e6, 0.01])
def test_recursive_least_squares_is_the_batch_solution(covariance: float) -> None:
    data = problem()
    expected = augmented(data, covariance**-0.5)
    np.testing.assert_allclose(solve("rls", data, covariance=covariance).parameters, expected, rtol=1e-6)


@pytest.mark.parametrize("forgetting", [1.0, 0.98])
def test_recursive_least_squares_matches_the_published_recursion(forgetting: float) -> None:
    """In matrix form, three rows of an instant at a time, as Islam and Bernstein print it; given joint by joint."""
    data = problem()
    P, theta = 1e3 * np.eye(6) * forgetting, np.zeros(6)
    for first in range(0, 399, 3):
        phi, y = data.regressor[first : first + 3], data.torque[first : first + 3]
        P = P / forgetting
        P = P - P @ phi.T @ np.linalg.inv(np.eye(3) + phi @ P @ phi.T) @ phi @ P
        theta = theta + P @ phi.T @ (y - phi @ theta)
    by_joint = np.arange(399).reshape(133, 3).T.ravel()
    rows = Problem(data.regressor[by_joint], data.torque[by_joint], BOUNDS, instant=by_joint // 3)
    result = solve("rls", rows, covariance=1e3, forgetting=forgetting)
    np.testing.assert_allclose(result.parameters, theta, rtol=1e-7)
    if forgetting < 1:
        weight = forgetting ** (132 - np.arange(399) // 3)
        residual = data.torque[:399] - data.regressor[:399] @ theta
        assert result.objective == pytest.approx(weight @ residual**2 + forgetting**132 * theta @ theta / 1e3)
