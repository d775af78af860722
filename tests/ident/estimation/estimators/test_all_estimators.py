"""Requirements that every estimator meets."""

from typing import Any

import numpy as np
import pytest

from ident.basics import plugins
from ident.estimation import estimators
from ident.estimation.problem import Problem
from recordings.errors import BadInput

NAMES = plugins.names("ident.estimation.estimators")
TRUTH = np.array([2.0, -0.5, 30.0, 0.1])


def estimate(name: str, seed: int, noise: float) -> estimators.Estimate:
    rng = np.random.default_rng(5)
    regressor = rng.normal(size=(600, 4)) * [1, 10, 0.1, 3]
    bounds = np.array([[-10, 10], [-5, 5], [-100, 100], [0, 1.0]])
    torque = regressor @ TRUTH + noise * rng.normal(size=600)
    problem = Problem(regressor, torque, bounds, deviation=np.ones(600))
    settings = estimators.settings(name, {})
    return estimators.load(name).estimate(problem, np.random.default_rng(seed), lambda *_: None, settings)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_planted_parameters_are_recovered_and_the_same_with_the_same_seed(name: str, noise: float) -> None:
    result, again = (estimate(name, 1, noise) for _ in range(2))
    np.testing.assert_allclose(result.parameters, TRUTH, rtol=1e-2)
    assert np.isfinite(result.objective)
    assert result.history[-1] == result.objective
    assert (np.diff(result.history) <= 0).all()
    np.testing.assert_array_equal(again.parameters, result.parameters)
    np.testing.assert_array_equal(again.history, result.history)


@pytest.mark.parametrize("name", NAMES)
def test_progress_is_reported_within_the_total(name: str) -> None:
    calls: list[tuple[Any, ...]] = []
    problem = Problem(np.eye(4), np.arange(4.0), np.tile([-9.0, 9.0], (4, 1)), np.ones(4))
    settings = estimators.settings(name, {})
    estimators.load(name).estimate(problem, np.random.default_rng(0), lambda *step: calls.append(step), settings)
    assert calls
    assert all(0 < done <= total for done, total, *_ in calls)


def test_only_the_baselines_identify_the_linear_form_of_the_paper() -> None:
    forms = {name: estimators.form(name) for name in NAMES}
    assert {name for name, form in forms.items() if form} == {"rls", "dls", "svd"}
    assert set(forms.values()) == {None, "lagrange14"}


@pytest.mark.parametrize(
    ("name", "invalid", "message"),
    [
        ("rls", {"forgetting": 1.1}, "forgetting: a number from 0.5 to 1 expected, 1.1 found"),
        ("rls", {"covariance": 0.0}, "covariance: a number above 0 expected, 0.0 found"),
        ("dls", {"damping": -1.0}, "damping: a number from 0 expected, -1.0 found"),
        ("dls", {"damping": np.nan}, "damping: a number from 0 expected, nan found"),
        ("svd", {"threshold": 1.0}, "threshold: a number from 0 to below 1 expected, 1.0 found"),
        *(("pso", {"neighbours": n}, f"an even number below .* 300, expected, {n} found") for n in (7, 300)),
        ("pso", {"neighbours": -2}, "neighbours: an integer from 0 expected, -2 found"),
        ("pso_classic", {"particles": 1}, "particles: an integer from 2 to 100000 expected, 1 found"),
        ("pso_classic", {"iterations": 0}, "iterations: an integer from 1 expected, 0 found"),
        ("pso_classic", {"inertia": 1.5}, "inertia: a number from 0 to 1 expected, 1.5 found"),
        ("pso_classic", {"social": -1.0}, "social: a number from 0 to 1e.06 expected, -1.0 found"),
        ("pso_classic", {"tolerance": 1.0}, "tolerance: a number from 0 to below 1 expected, 1.0 found"),
    ],
)
def test_invalid_settings_are_refused(name: str, invalid: dict[str, float], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        estimators.settings(name, invalid)


def test_the_error_for_an_unknown_estimator_lists_the_known_ones() -> None:
    with pytest.raises(BadInput, match="pso"):
        estimators.load("magic")
