"""Least absolute deviations by the interior point method, against known minima."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.estimation.lad_interior_point import iterates
from recordings.recording import Floats


def minimise(regressor: Floats, torque: Floats, bounds: Floats) -> tuple[Floats, Floats]:
    """The last iterate with the smallest objective."""
    return min(
        iterates(regressor, torque, bounds), key=lambda pair: float(np.abs(torque - regressor @ pair[0]).sum())
    )


def test_location_is_the_median() -> None:
    torque = np.random.default_rng(0).standard_cauchy(501)
    x, _ = minimise(np.ones((501, 1)), torque, np.array([[-100.0, 100.0]]))
    assert x == pytest.approx([np.median(torque)], abs=1e-8)


def test_exact_data_are_reproduced() -> None:
    rng = np.random.default_rng(1)
    regressor, truth = rng.normal(size=(200, 4)) * [1e-3, 1.0, 1e3, 1.0], np.array([1.0, -2.0, 3.0, 0.0])
    x, _ = minimise(regressor, regressor @ truth, np.tile([-10.0, 10.0], (4, 1)))
    np.testing.assert_allclose(x, truth, atol=1e-7)


def test_outliers_do_not_matter() -> None:
    """A tenth of the rows is wrong by any amount."""
    rng = np.random.default_rng(2)
    regressor, truth = rng.normal(size=(200, 3)), np.array([1.0, -2.0, 3.0])
    torque = regressor @ truth
    torque[::10] += 1e6 * rng.normal(size=20)
    x, _ = minimise(regressor, torque, np.tile([-10.0, 10.0], (3, 1)))
    np.testing.assert_allclose(x, truth, atol=1e-6)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), m=st.integers(5, 60), k=st.integers(1, 4))
def test_iterates_stay_in_the_box_and_the_dual_within_one(seed: int, m: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    regressor, torque = rng.normal(size=(m, k)), rng.normal(size=m)
    bounds = np.sort(rng.normal(size=(k, 2)), axis=1)
    gaps = []
    for x, y in iterates(regressor, torque, bounds):
        assert ((bounds[:, 0] <= x) & (x <= bounds[:, 1])).all()
        assert (np.abs(y) <= 1).all()
        slope = regressor.T @ y
        dual = torque @ y - np.maximum(slope * bounds[:, 0], slope * bounds[:, 1]).sum()
        gaps.append(np.abs(torque - regressor @ x).sum() - dual)
        assert gaps[-1] > -1e-9 * (1 + np.abs(torque).sum())
    assert min(gaps) < 1e-6 * (1 + np.abs(torque).sum())


def test_unit_of_a_parameter_does_not_matter() -> None:
    rng = np.random.default_rng(3)
    regressor, torque = rng.normal(size=(100, 2)), rng.normal(size=100)
    bounds = np.tile([-5.0, 5.0], (2, 1))
    units = np.array([1e-4, 1e4])
    x, _ = minimise(regressor, torque, bounds)
    scaled, _ = minimise(regressor * units, torque, bounds / units[:, None])
    np.testing.assert_allclose(scaled * units, x, rtol=1e-6)


def test_minimum_outside_of_the_box_is_found_on_its_edge() -> None:
    torque = np.full(50, 3.0)
    x, _ = minimise(np.ones((50, 1)), torque, np.array([[-1.0, 2.0]]))
    assert x == pytest.approx([2.0], abs=1e-6)
