import numpy as np
import pytest

from ident.identification.goodness_of_fit import goodness_of_fit


def test_is_eq_41_with_the_range_of_the_models_torque() -> None:
    measured = np.array([[0.0], [1.0], [2.0], [3.0]])
    computed = np.array([[0.5], [1.5], [2.5], [4.5]])
    fit = goodness_of_fit(measured, computed)
    rms = np.sqrt((3 * 0.5**2 + 1.5**2) / 4)
    assert fit.rms == pytest.approx((rms,))
    assert fit.nrmse == pytest.approx((1 - rms / 4,))
    assert fit.r2 == pytest.approx((1 - rms**2 / 1.25,))


def test_a_perfect_model_scores_one_on_every_joint() -> None:
    torque = np.random.default_rng(0).normal(size=(50, 4))
    fit = goodness_of_fit(torque, torque)
    assert fit.nrmse == fit.r2 == (1.0,) * 4
    assert fit.rms == (0.0,) * 4


def test_samples_that_are_not_known_do_not_count() -> None:
    rng = np.random.default_rng(1)
    measured, computed = rng.normal(size=(2, 30, 2))
    expected = goodness_of_fit(measured[:20], computed[:20])
    measured[20:25], computed[25:] = np.nan, np.nan
    assert goodness_of_fit(measured, computed) == expected
