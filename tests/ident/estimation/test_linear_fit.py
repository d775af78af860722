from collections.abc import Callable

import numpy as np
import pytest

from ident.basics import plugins
from ident.data.prepared_recording import prepare
from ident.dynamics.mechanisms import Parameter
from ident.estimation import estimators
from ident.estimation.linear_fit import Fit, fit, search_region
from ident.estimation.problem import Estimate
from ident.estimation.regression import Regression
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from tests.running import first_fast


def fitted(*recordings: Recording, preprocessing: str = "parallel") -> tuple[Fit, int]:
    """A fit of the mechanism, and the number of rows of the recordings."""
    regressions = [Regression.of_mechanism(prepare(recording, preprocessing, None)) for recording in recordings]
    parameters, generator = regressions[0].prepared.mechanism.parameters, np.random.default_rng(0)
    settings = estimators.settings("pso", {"iterations": 300})
    result = fit(regressions, parameters, "pso", settings, generator, lambda *_: None)
    return result, sum(len(regression.rows()[1]) for regression in regressions)


@pytest.mark.parametrize("preprocessing", first_fast(plugins.names("ident.data.preprocessing")))
def test_parameters_of_eq_36_are_estimated_within_one_percent(
    make: Callable[..., Recording], truth: Floats, preprocessing: str
) -> None:
    result, _ = fitted(make(cycles=3, noise=0.02), preprocessing=preprocessing)
    np.testing.assert_allclose(result.parameters, truth, rtol=0.01)
    assert not any(result.at_bound)


def test_recordings_are_fitted_together(make: Callable[..., Recording], truth: Floats) -> None:
    result, rows = fitted(make("fig5a", cycles=1), make("fig5b", cycles=1))
    assert result.rows == rows
    np.testing.assert_allclose(result.parameters, truth, rtol=0.01)


def test_the_search_region_scales_with_the_torque() -> None:
    rng = np.random.default_rng(0)
    regressor, torque = rng.normal(size=(100, 2)), rng.normal(size=100)
    parameters = (Parameter("mass", "kg", "a mass", nonnegative=True), Parameter("c", "N m", "friction"))
    bounds = search_region(parameters, regressor, torque)
    assert bounds[0, 0] == 0
    assert bounds[1, 0] == -bounds[1, 1]
    np.testing.assert_allclose(search_region(parameters, regressor, 7 * torque), 7 * bounds)


def test_the_error_names_a_parameter_without_effect() -> None:
    parameters = (Parameter("mass", "kg", "a mass"), Parameter("drag", "N m", "what the air does"))
    with pytest.raises(BadInput, match="drag \\(what the air does\\)"):
        search_region(parameters, np.array([[1.0, 0.0], [2.0, 0.0]]), np.ones(2))


def test_a_parameter_at_a_bound_is_flagged() -> None:
    bounds = np.array([[0.0, 10.0]] * 3)
    estimate = Estimate(np.array([1e-9, 5.0, 10.0]), 0.0, np.zeros(1))
    assert Fit(estimate, bounds, rows=1).at_bound == (True, False, True)
