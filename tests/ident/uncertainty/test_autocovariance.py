"""Variances of sums of autocorrelated noise, against analytic values of autoregressive processes."""

import numpy as np
import pytest
from scipy.signal import lfilter

from ident.uncertainty.autocovariance import StationaryNoise, bandwidth, variance_of_sum
from recordings.recording import Floats


def autoregressive(rng: np.random.Generator, shape: tuple[int, int], rho: float) -> Floats:
    """(m, s) first-order autoregressive noise of variance one."""
    settling = 400
    white = rng.normal(0.0, np.sqrt(1 - rho**2), (settling + shape[0], shape[1]))
    coloured: Floats = lfilter([1.0], [1.0, -rho], white, axis=0)[settling:]
    return coloured


def stationary(*blocks: Floats) -> StationaryNoise:
    return StationaryNoise.estimate(blocks, [np.ones_like(block) for block in blocks])


@pytest.mark.parametrize("rho", [-0.6, 0.3, 0.8])
def test_bandwidth_is_andrews_formula_of_the_autocorrelation(rho: float) -> None:
    rows = 200_000
    noise = autoregressive(np.random.default_rng(0), (rows, 1), rho)
    alpha = 4 * rho**2 / (1 - rho) ** 4
    assert bandwidth([noise]) == pytest.approx(2.6614 * (alpha * rows) ** 0.2, rel=0.03)
    trend = np.arange(50.0)[:, None]
    assert bandwidth([trend]) <= 50
    assert bandwidth([1e-9 * trend]) == pytest.approx(bandwidth([trend]))


@pytest.mark.parametrize("rho", [-0.5, 0.0, 0.5, 0.9])
def test_variance_of_a_sum_is_the_long_run_variance(rho: float) -> None:
    """The sum of n values has the variance n (1 + rho) / (1 - rho), less a term that does not grow with n."""
    rows, rng = 4000, np.random.default_rng(1)
    expected = rows * (1 + rho) / (1 - rho) - 2 * rho * (1 - rho**rows) / (1 - rho) ** 2
    draws = [autoregressive(rng, (rows, 1), rho) for _ in range(60)]
    ones = np.ones((rows, 1, 1))
    for variance in (lambda x: variance_of_sum([x]), lambda x: stationary(x).variance_of_sums([ones])):
        assert np.mean([variance(x)[0][0, 0] for x in draws]) == pytest.approx(expected, rel=0.08)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_degrees_of_freedom_describe_the_scatter_of_the_variance(rho: float) -> None:
    """A variance with nu degrees of freedom has a relative variance of 2 / nu."""
    rng = np.random.default_rng(3)
    factor = np.sin(2 * np.pi * np.arange(600) / 50)[:, None, None]
    results = [stationary(autoregressive(rng, (600, 1), rho)).variance_of_sums([factor]) for _ in range(600)]
    variances = np.array([total[0, 0] for total, _ in results])
    freedom = np.median([freedom[0] for _, freedom in results])
    assert 2 * variances.mean() ** 2 / variances.var() == pytest.approx(freedom, rel=0.35)


def test_noise_that_joints_share_adds_up_or_cancels() -> None:
    noise = autoregressive(np.random.default_rng(4), (1000, 1), 0.5)
    ones = np.ones((1000, 2, 1))
    single = stationary(noise).variance_of_sums([ones[:, :1]])[0]
    same, opposite = (
        stationary(np.hstack([noise, sign * noise])).variance_of_sums([ones])[0] for sign in (1.0, -1.0)
    )
    assert same == pytest.approx(4 * single)
    assert opposite == pytest.approx(0.0, abs=1e-9 * float(single[0, 0]))


def test_joint_that_follows_another_has_its_autocovariance_shifted() -> None:
    noise = autoregressive(np.random.default_rng(5), (200_000, 1), 0.8)
    process = stationary(np.hstack([noise, np.roll(noise, 3, axis=0)]))
    lags, correlation = np.arange(7), process.covariance[:7] / process.weights[:7, None, None]
    np.testing.assert_allclose(correlation[:, 0, 0], 0.8**lags, atol=0.03)
    np.testing.assert_allclose(correlation[:, 0, 1], 0.8 ** np.abs(lags - 3), atol=0.03)
    np.testing.assert_allclose(correlation[:, 1, 0], 0.8 ** (lags + 3.0), atol=0.03)


def test_missing_samples_do_not_bias_the_autocovariance_and_recordings_add_up() -> None:
    rng = np.random.default_rng(6)
    noise = autoregressive(rng, (100_000, 1), 0.7)
    valid = (rng.random(noise.shape) < 0.5).astype(float)
    process = StationaryNoise.estimate([noise * valid], [valid])
    np.testing.assert_allclose(process.covariance[:5, 0, 0] / process.weights[:5], 0.7 ** np.arange(5), atol=0.03)
    assert process.samples == pytest.approx(valid.sum())
    ones = [np.ones((900, 1, 1)), np.ones((600, 1, 1))]
    total, _ = process.variance_of_sums(ones)
    assert total == pytest.approx(sum(process.variance_of_sums([block])[0] for block in ones))


@pytest.mark.parametrize("size", [0.0, 1e-320, 1e-200])
def test_bandwidth_of_tiny_noise_does_not_depend_on_its_unit(size: float) -> None:
    noise = np.random.default_rng(0).normal(size=(200, 3))
    expected = 1.0 if size < 1e-300 else bandwidth([noise])
    assert bandwidth([size * noise]) == pytest.approx(expected)
