"""Confidence intervals: analytic covariances, invariances, and the coverage of nominal 95 % intervals."""

from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import fftconvolve, lfilter
from scipy.stats import t as student

from ident.basics import filters
from ident.estimation.lad_certificate import certify
from ident.uncertainty import covariance
from ident.uncertainty.covariance import IntervalMethod, Uncertainty, estimate, least_absolute, least_squares
from recordings.errors import BadInput
from recordings.recording import Floats, Ints

TRUTH = np.array([0.5, 1.2, 3.0])
WIDE = np.tile([-100.0, 100.0], (3, 1))
CYCLES = 8
Draw = Callable[[np.random.Generator, int, int], Floats]
"""Noise (m, dof) of variance one."""
Loss = Literal["squares", "weighted squares", "absolute deviations"]


def motion_columns(m: int, dof: int = 2) -> tuple[Floats, Ints]:
    """Acceleration, velocity and its sign (m, dof, 3) of a periodic motion, and the cycle (m,)."""
    turns = np.arange(m) / m * CYCLES
    angle = 2 * np.pi * turns[:, None] + np.arange(dof)
    velocity = np.cos(angle) + 0.5 * np.cos(2 * angle)
    acceleration = -np.sin(angle) - np.sin(2 * angle)
    return np.stack([acceleration, velocity, np.sign(velocity)], axis=2), np.floor(turns + 1e-9).astype(int)


def white(rng: np.random.Generator, m: int, dof: int) -> Floats:
    return rng.normal(size=(m, dof))


def autoregressive(rho: float) -> Draw:
    def draw(rng: np.random.Generator, m: int, dof: int) -> Floats:
        innovation = rng.normal(0.0, np.sqrt(1 - rho**2), (m + 400, dof))
        return np.asarray(lfilter([1.0], [1.0, -rho], innovation, axis=0)[400:])

    return draw


def low_passed(cutoff: float, rate: float) -> Draw:
    """White noise behind the low-pass of the preprocessing."""
    taps = filters.low_pass(cutoff, rate)

    def draw(rng: np.random.Generator, m: int, dof: int) -> Floats:
        noise = rng.normal(size=(m + len(taps) - 1, dof))
        return np.asarray(fftconvolve(noise, taps[:, None], "valid", axes=0) / np.linalg.norm(taps))

    return draw


def fit(
    regressor: Floats, torque: Floats, std: Floats, cycle: Ints, loss: Loss = "squares"
) -> tuple[Floats, tuple[covariance.Block, Floats]]:
    """Parameters (k,) that minimise the `loss`, and the rows for their uncertainty."""
    rows, measured = regressor.reshape(-1, regressor.shape[2]), torque.ravel()
    if loss == "absolute deviations":
        x = certify(rows, measured, WIDE[: rows.shape[1]]).parameters
        return x, least_absolute(regressor, torque - regressor @ x, std, cycle)
    weight = 1 / std if loss == "weighted squares" else np.ones_like(std)
    x = np.linalg.lstsq(rows * weight.reshape(-1, 1), measured * weight.ravel(), rcond=None)[0]
    return x, least_squares(regressor, torque - regressor @ x, std, cycle, weight)


def uncertainty(torque: Floats, loss: Loss = "squares", method: IntervalMethod = "stationary") -> Uncertainty:
    regressor, cycle = motion_columns(*torque.shape)
    return estimate([fit(regressor, torque, np.ones_like(torque), cycle, loss)[1]], method)


def coverage(
    draw: Draw,
    loss: Loss = "squares",
    method: IntervalMethod = "stationary",
    draws: int = 600,
    uneven: bool = False,
    m: int = 800,
) -> Floats:
    """(3,) share of the intervals that contain the true value. uneven: the noise grows with the speed."""
    rng = np.random.default_rng(0)
    regressor, cycle = motion_columns(m)
    std = 0.2 + np.abs(regressor[:, :, 1]) if uneven else np.ones((m, 2))
    inside = np.zeros(3)
    for _ in range(draws):
        x, rows = fit(regressor, regressor @ TRUTH + std * draw(rng, m, 2), std, cycle, loss)
        inside += np.abs(x - TRUTH) <= estimate([rows], method).half_width()
    return inside / draws


NOISES: dict[str, Draw] = {
    "white": white,
    "AR(1) 0.5": autoregressive(0.5),
    "AR(1) 0.9": autoregressive(0.9),
    "low-pass at 0.24 of the rate": low_passed(30.0, 125.0),
    "low-pass at 0.06 of the rate": low_passed(30.0, 500.0),
}
FAST: list[tuple[str, Loss, IntervalMethod, bool, int]] = [
    ("white", "squares", "stationary", False, 600),
    ("AR(1) 0.9", "squares", "stationary", False, 600),
    ("low-pass at 0.24 of the rate", "squares", "stationary", False, 600),
    ("white", "squares", "stationary", True, 600),
    ("AR(1) 0.9", "weighted squares", "stationary", True, 600),
    ("AR(1) 0.5", "squares", "hac", False, 600),
    ("low-pass at 0.24 of the rate", "squares", "cycles", False, 600),
    ("white", "absolute deviations", "stationary", False, 300),
]
"""Noise, loss, method, whether the noise grows with the speed, and draws."""
SLOW: list[tuple[str, Loss, IntervalMethod, bool, int]] = [
    ("low-pass at 0.24 of the rate", "absolute deviations", "stationary", False, 300),
    ("AR(1) 0.5", "squares", "stationary", False, 500),
    ("low-pass at 0.06 of the rate", "squares", "stationary", False, 500),
    ("AR(1) 0.5", "absolute deviations", "stationary", False, 500),
    ("AR(1) 0.9", "absolute deviations", "stationary", False, 500),
    ("low-pass at 0.06 of the rate", "absolute deviations", "stationary", False, 500),
]


@pytest.mark.parametrize(
    ("noise", "loss", "method", "uneven", "draws"),
    [*FAST, *(pytest.param(*case, marks=pytest.mark.slow) for case in SLOW)],
)
def test_intervals_cover_the_truth(noise: str, loss: Loss, method: IntervalMethod, uneven: bool, draws: int) -> None:
    """Three parameters: the binomial error of the mean coverage is 0.5 % with 600 draws, 0.7 % with 300."""
    assert 0.93 <= coverage(NOISES[noise], loss, method, draws, uneven).mean() <= 0.97


def test_white_noise_gives_the_textbook_covariance_of_least_squares() -> None:
    """sigma^2 (X' X)^-1, and student's t with as many degrees of freedom as there are rows, about."""
    torque = 0.3 * white(np.random.default_rng(1), 20_000, 1)
    regressor = motion_columns(20_000, 1)[0][:, 0]
    expected = 0.09 * np.linalg.inv(regressor.T @ regressor)
    result = uncertainty(torque)
    np.testing.assert_allclose(result.std, np.sqrt(np.diag(expected)), rtol=0.05)
    np.testing.assert_allclose(result.correlation, expected / np.outer(result.std, result.std), atol=0.05, rtol=0.1)
    np.testing.assert_allclose(result.half_width(), 1.96 * result.std, rtol=0.01)
    half, (columns, cycle) = np.where(np.arange(20_000)[:, None] % 2, np.nan, torque), motion_columns(20_000, 1)
    of_half = estimate([least_squares(columns, half, np.ones_like(half), cycle)])
    np.testing.assert_allclose(of_half.std, np.sqrt(2) * result.std, rtol=0.1)


@pytest.mark.parametrize(
    ("distribution", "ratio", "smoothing"), [("normal", np.pi / 2, 1.09), ("laplace", 0.5, 1.59)]
)
def test_efficiency_of_least_absolute_deviations(distribution: str, ratio: float, smoothing: float) -> None:
    """Its variance is pi / 2 times that of least squares for normal noise, and half of it for Laplace's noise.

    smoothing: squared ratio of the density at zero to that behind the kernel of 0.3 standard deviations: the
    estimated variance is too large by it.
    """
    ratios = []
    for seed in range(8):
        torque = getattr(np.random.default_rng(seed), distribution)(size=(4000, 1))
        ratios.append((uncertainty(torque, "absolute deviations").std / uncertainty(torque).std) ** 2)
    assert np.mean(ratios) == pytest.approx(ratio * smoothing, rel=0.05)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    units=st.lists(st.floats(1e-4, 1e4), min_size=3, max_size=3),
    torque_unit=st.floats(1e-4, 1e4),
    method=st.sampled_from(["stationary", "hac", "cycles"]),
    loss=st.sampled_from(["squares", "absolute deviations"]),
)
def test_intervals_follow_the_units(
    seed: int, units: list[float], torque_unit: float, method: IntervalMethod, loss: Loss
) -> None:
    regressor, cycle = motion_columns(96)
    residual = autoregressive(0.5)(np.random.default_rng(seed), 96, 2)
    rows = least_absolute if loss == "absolute deviations" else least_squares
    std = np.ones_like(residual)
    expected = estimate([rows(regressor, residual, std, cycle)], method)
    changed = estimate([rows(regressor * units, torque_unit * residual, torque_unit * std, cycle)], method)
    np.testing.assert_allclose(changed.half_width(), torque_unit * expected.half_width() / units, rtol=1e-6)
    np.testing.assert_allclose(changed.correlation, expected.correlation, atol=1e-6)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), method=st.sampled_from(["stationary", "hac", "cycles"]))
def test_order_of_joints_and_direction_of_time_do_not_matter(seed: int, method: IntervalMethod) -> None:
    rng = np.random.default_rng(seed)
    regressor, cycle = motion_columns(400)
    residual, std = autoregressive(0.5)(rng, 400, 2), rng.uniform(0.5, 2.0, (400, 2))
    residual[rng.random(residual.shape) < 0.1] = np.nan
    expected = estimate([least_squares(regressor, residual, std, cycle)], method).covariance
    # The bandwidth is estimated from all rows but the last: backwards it differs a little.
    for order, tolerance in (((slice(None), [1, 0]), 1e-9), ((slice(None, None, -1), slice(None)), 0.05)):
        changed = least_squares(regressor[order], residual[order], std[order], cycle[order[0]])
        result = estimate([changed], method).covariance
        np.testing.assert_allclose(result, expected, rtol=0, atol=tolerance * np.abs(expected).max())


def test_long_recordings_are_split_without_changing_the_result_much(monkeypatch: pytest.MonkeyPatch) -> None:
    torque = autoregressive(0.5)(np.random.default_rng(3), 8000, 2)
    for method in ("stationary", "hac"):
        whole = uncertainty(torque, method=method).std
        monkeypatch.setattr(covariance, "_BLOCK", 1000)
        np.testing.assert_allclose(uncertainty(torque, method=method).std, whole, rtol=0.03)
        monkeypatch.undo()


def test_repetitions_are_independent_blocks() -> None:
    """C repetitions give Student's t with C - 1 degrees of freedom; without two, there is no interval."""
    result = uncertainty(white(np.random.default_rng(5), 400, 1), method="cycles")
    np.testing.assert_array_equal(result.degrees_of_freedom, CYCLES - 1.0)
    np.testing.assert_allclose(result.half_width(), student.ppf(0.975, CYCLES - 1) * result.std)
    wave = np.tile(np.sin(np.linspace(0, 6 * np.pi, 50)), CYCLES)[:, None]  # what repeats is no noise
    assert uncertainty(wave, method="cycles").std.max() < 1e-9 < 1e-3 < uncertainty(wave).std.max()
    ones = np.ones((50, 1, 1))
    with pytest.raises(BadInput, match="need at least two of the motion, 1 found"):
        estimate([least_squares(ones, ones[:, :, 0], ones[:, :, 0], np.zeros(50, int))], "cycles")


def test_uncertain_gain_widens_the_interval_by_its_share() -> None:
    noisy = Uncertainty("stationary", np.diag([0.01, 0.04]), np.full(2, np.inf))
    width = np.ptp(noisy.interval(np.array([2.0, -1.0]), 0.1), axis=1) / 2
    np.testing.assert_allclose(width, 1.96 * np.hypot([0.1, 0.2], [0.2, 0.1]), rtol=1e-4)
