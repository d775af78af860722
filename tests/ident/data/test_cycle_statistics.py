"""Synthetic truth: a waveform that repeats, autocorrelated noise that does not, a trend where one is planted."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator
from scipy.signal import lfilter

from ident.data.cycle_statistics import by_cycle, of_residuals, pooled, of_cycles
from ident.data.dataset import Dataset, build
from ident.dynamics import mechanisms
from recordings.recording import Floats, Recording

PHASES = 500
PHASE = np.arange(PHASES) / PHASES


def noise(rng: Generator, cycles: int, correlation: float = 0.9) -> Floats:
    """(cycles, PHASES) of variance one, first-order autoregressive along the phase, louder at some phases."""
    white = rng.normal(size=(cycles, PHASES + 200))
    even = lfilter([np.sqrt(1 - correlation**2)], [1, -correlation], white)[:, 200:]
    loudness = 0.3 + np.abs(np.sin(6 * np.pi * PHASE))
    return even * loudness / np.sqrt(np.mean(loudness**2))


@given(
    seed=st.integers(0, 2**32 - 1),
    cycles=st.integers(2, 8),
    amplitude=st.floats(0, 3),
    lost=st.floats(0, 0.3),
)
def test_the_parts_are_found_and_add_up(seed: int, cycles: int, amplitude: float, lost: float) -> None:
    rng = np.random.default_rng(seed)
    residual = noise(rng, cycles, 0.5) + amplitude * np.sin(2 * np.pi * PHASE)
    residual[rng.random(residual.shape) < lost] = np.nan
    residual[-1, 400:] = np.nan  # cut short
    found = of_cycles(residual[:, :, None])
    assert found is not None
    (joint,) = found
    trend = joint.trend.mean_square if joint.trend and joint.trend.significant else 0.0
    assert joint.total == pytest.approx(joint.noise + joint.repeating + trend)
    assert joint.noise == pytest.approx(1.0, abs=0.5)
    assert joint.repeating == pytest.approx(amplitude**2 / 2, abs=0.3 + 0.3 * amplitude)


def test_noise_is_unbiased_even_with_two_repetitions() -> None:
    rng = np.random.default_rng(0)
    parts = [of_cycles(noise(rng, 2)[:, :, None]) for _ in range(200)]
    whole = pooled([part for part in parts if part])
    assert whole is not None
    assert whole[0].noise == pytest.approx(1.0, abs=0.03)
    assert whole[0].repeating == pytest.approx(0.0, abs=0.03)
    assert whole[0].trend is None


@pytest.mark.parametrize("cycles", [3, 5, 10])
def test_chance_alone_is_rarely_called_a_trend(cycles: int) -> None:
    rng = np.random.default_rng(cycles)
    trends = [of_cycles(noise(rng, cycles)[:, :, None])[0].trend for _ in range(200)]  # type: ignore[index]
    assert sum(trend.significant for trend in trends if trend) <= 3
    assert sum(trend.p_value < 0.1 for trend in trends if trend) < 40


@pytest.mark.parametrize(
    ("pattern", "course"),
    [("linear", np.linspace(-1, 1, 6)), ("step after 4", np.array([0, 0, 0, 0, 1, 1]))],
)
def test_a_trend_is_kept_apart_from_noise(pattern: str, course: Floats) -> None:
    rng = np.random.default_rng(0)
    residual = noise(rng, 6, 0.2) + course[:, None] * np.sign(np.sin(4 * np.pi * PHASE))
    (joint,) = of_cycles(residual[:, :, None])  # type: ignore[misc]
    assert joint.trend is not None
    assert joint.trend.significant
    assert joint.trend.pattern == pattern
    assert joint.noise == pytest.approx(1.0, abs=0.15)
    assert joint.trend.mean_square == pytest.approx(np.var(course), abs=0.1)


def test_what_repeats_is_told_from_chance() -> None:
    rng = np.random.default_rng(0)
    chance = [of_cycles(noise(rng, 4)[:, :, None])[0].repeating_p for _ in range(200)]  # type: ignore[index]
    assert 2 <= sum(p < 0.05 for p in chance) <= 30
    (joint,) = of_cycles((noise(rng, 4, 0.2) + np.sin(2 * np.pi * PHASE))[:, :, None])  # type: ignore[misc]
    assert joint.repeating_p < 1e-6
    assert joint.above_noise == pytest.approx(1 / 3, abs=0.1)


def test_one_repetition_has_no_floor() -> None:
    assert of_cycles(np.ones((1, 20, 3))) is None
    residual = np.ones((2, 20, 1))
    residual[0, 10:] = residual[1, :10] = np.nan
    assert of_cycles(residual) is None


def test_no_noise_at_all_is_no_trend() -> None:
    (joint,) = of_cycles(np.tile(PHASE, (4, 1))[:, :, None])  # type: ignore[misc]
    assert joint.noise == pytest.approx(0.0, abs=1e-20)
    assert joint.above_noise == pytest.approx(1.0)
    assert joint.trend is not None
    assert not joint.trend.significant


def prepared(recording: Recording, cutoff: float) -> Dataset:
    return build(recording, mechanisms.create(recording.rig), "parallel", cutoff)


@pytest.mark.parametrize("cutoff", [30, 37, 24])  # 4, 3, 5 samples to a row; 2000 to a repetition
def test_equal_phases_stand_side_by_side(make: Callable[..., Recording], cutoff: float) -> None:
    dataset = prepared(make(cycles=4), cutoff)
    table = by_cycle(dataset, dataset.torque)
    period = dataset.recording.run.period
    assert table.shape[0] == 4
    assert abs(table.shape[1] - period * dataset.rate) < 1
    spread = np.nanstd(table, axis=0)
    assert np.isfinite(table).mean() > 0.99
    assert np.nanmax(spread) < 2e-3 * np.nanstd(table)


def test_gaps_stay_gaps(make: Callable[..., Recording]) -> None:
    made = make(cycles=3)
    made.voltage[2600:2640, 1] = np.nan
    dataset = prepared(made, 30)
    table = by_cycle(dataset, dataset.torque)
    assert np.isnan(table).any(axis=(0, 1)).tolist() == [False, True, False]
    np.testing.assert_allclose(table[1][np.isfinite(table[1])], table[0][np.isfinite(table[1])], atol=1e-3)


def test_the_motion_waits_while_the_host_misses_its_turn(make: Callable[..., Recording]) -> None:
    made = make(cycles=3)
    later = np.arange(len(made.time)) >= 3100
    waited = replace(made, time=made.time + 7 * later / made.run.rate)
    dataset = prepared(waited, 30)
    table = by_cycle(dataset, dataset.torque)
    assert np.nanmax(np.nanstd(table, axis=0)) < 2e-3 * np.nanstd(table)


def test_lost_samples_do_not_shift_what_follows(make: Callable[..., Recording]) -> None:
    made = make(cycles=3)
    there = np.delete(np.arange(len(made.time)), np.r_[2480:2520, 3300])  # over the end of the first repetition
    fewer = replace(made, **{name: getattr(made, name)[there] for name in ("time", "position", "voltage", "repeat")})
    dataset = prepared(fewer, 30)
    table = by_cycle(dataset, dataset.torque)
    assert np.nanmax(np.nanstd(table, axis=0)) < 2e-3 * np.nanstd(table)


def test_planted_voltage_noise_is_the_floor(make: Callable[..., Recording], truth: Floats) -> None:
    dataset = prepared(make(cycles=4, noise=0.02), 30)
    exact = prepared(make(cycles=4), 30)
    added = dataset.torque - exact.torque
    found = of_residuals([dataset], [dataset.torque - dataset.regressor @ truth])
    assert found is not None
    for joint, rms in zip(found, np.sqrt(np.nanmean(added**2, axis=0)), strict=True):
        assert joint.noise_rms == pytest.approx(rms, rel=0.08)
        assert joint.above_noise < 0.08


def test_a_motion_that_does_not_repeat_has_no_floor(make: Callable[..., Recording]) -> None:
    made = make(cycles=2)
    dataset = prepared(replace(made, repeat=np.full_like(made.repeat, -1)), 30)
    assert of_residuals([dataset], [dataset.torque]) is None
