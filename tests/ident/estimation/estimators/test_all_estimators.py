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


def test_the_error_for_an_unknown_estimator_lists_the_known_ones() -> None:
    with pytest.raises(BadInput, match="pso"):
        estimators.load("magic")
