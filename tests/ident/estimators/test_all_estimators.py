"""What every estimator must do, whatever it is."""

import numpy as np
import pytest

from ident import discovery, estimators
from recordings.errors import BadInput

NAMES = discovery.names("estimators")


def estimate(name: str, seed: int) -> estimators.Estimate:
    rng = np.random.default_rng(5)
    regressor = rng.normal(size=(600, 4)) * [1, 10, 0.1, 3]
    truth = np.array([2.0, -0.5, 30.0, 0.1])
    bounds = np.array([[-10, 10], [-5, 5], [-100, 100], [0, 1.0]])
    torque = regressor @ truth + 1e-3 * rng.normal(size=600)
    module = estimators.load(name)
    generator = np.random.default_rng(seed)
    return module.estimate(regressor, torque, bounds, generator, lambda *_: None, estimators.settings(name, {}))


@pytest.mark.parametrize("name", NAMES)
def test_recovers_planted_parameters(name: str) -> None:
    found = estimate(name, seed=1)
    np.testing.assert_allclose(found.parameters, [2.0, -0.5, 30.0, 0.1], rtol=1e-2)
    assert found.history[-1] == found.objective
    assert (np.diff(found.history) <= 0).all()


@pytest.mark.parametrize("name", NAMES)
def test_same_seed_same_bits(name: str) -> None:
    one, other = estimate(name, seed=2), estimate(name, seed=2)
    np.testing.assert_array_equal(one.parameters, other.parameters)
    np.testing.assert_array_equal(one.history, other.history)


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_setting_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match="warp_factor"):
        estimators.settings(name, {"warp_factor": 9})


def test_an_unknown_estimator_is_refused_with_those_there_are() -> None:
    with pytest.raises(BadInput, match="pso"):
        estimators.load("magic")
