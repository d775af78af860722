"""Synthetic residuals: a repeating waveform, autocorrelated noise and, in some tests, a trend."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator
from scipy.signal import lfilter

from ident.data.cycle_statistics import by_cycle, of_cycles, of_residuals, pooled, repeating_share
from ident.data.prepared_recording import PreparedRecording, prepare
from recordings.recording import Floats, Recording
from tests.ident import building

PHASES = 500
PHASE = np.arange(PHASES) / PHASES


def noise(rng: Generator, cycles: int, correlation: float = 0.9) -> Floats:
    """(cycles, PHASES) of variance one, first-order autoregressive along the phase, with a phase-dependent level."""
    white = rng.normal(size=(cycles, PHASES + 200))
    even = lfilter([np.sqrt(1 - correlation**2)], [1, -correlation], white)[:, 200:]
    level = 0.3 + np.abs(np.sin(6 * np.pi * PHASE))
    return even * level / np.sqrt(np.mean(level**2))


@given(
    seed=st.integers(0, 2**32 - 1),
    cycles=st.integers(2, 8),
    amplitude=st.floats(0, 3),
    lost=st.floats(0, 0.3),
)
def test_mean_square_is_decomposed_into_repeating_and_changing_part_and_noise(
    seed: int, cycles: int, amplitude: float, lost: float
) -> None:
    rng = np.random.default_rng(seed)
    residual = noise(rng, cycles, 0.5) + amplitude * np.sin(2 * np.pi * PHASE)
    residual[rng.random(residual.shape) < lost] = np.nan
    residual[-1, 400:] = np.nan  # cut short
    statistics = of_cycles(residual[:, :, None])
    assert statistics is not None
    (joint_statistics,) = statistics
    parts = joint_statistics.noise + joint_statistics.repeating + joint_statistics.changing
    assert joint_statistics.total == pytest.approx(parts)
    assert joint_statistics.changing == pytest.approx(0.0, abs=0.8)
    assert joint_statistics.noise == pytest.approx(1.0, abs=0.8)
    assert joint_statistics.repeating == pytest.approx(amplitude**2 / 2, abs=0.5 + 0.5 * amplitude)


def test_noise_is_unbiased_with_two_cycles() -> None:
    rng = np.random.default_rng(0)
    statistics = [of_cycles(noise(rng, 2)[:, :, None]) for _ in range(200)]
    mean_statistics = pooled([realisation for realisation in statistics if realisation])
    assert mean_statistics is not None
    assert mean_statistics[0].noise == pytest.approx(1.0, abs=0.03)
    assert mean_statistics[0].repeating == pytest.approx(0.0, abs=0.03)
    assert mean_statistics[0].trend is None


@pytest.mark.parametrize("cycles", [3, 5, 10])
def test_noise_rarely_gives_a_significant_trend(cycles: int) -> None:
    rng = np.random.default_rng(cycles)
    trends = [of_cycles(noise(rng, cycles)[:, :, None])[0].trend for _ in range(200)]  # type: ignore[index]
    assert sum(trend.significant for trend in trends if trend) <= 3
    assert sum(trend.p_value < 0.1 for trend in trends if trend) < 40


@pytest.mark.parametrize(
    ("pattern", "profile"),
    [("linear", np.linspace(-1, 1, 6)), ("step after 4", np.array([0, 0, 0, 0, 1, 1]))],
)
def test_a_trend_is_separated_from_noise(pattern: str, profile: Floats) -> None:
    rng = np.random.default_rng(0)
    residual = noise(rng, 6, 0.2) + profile[:, None] * np.sign(np.sin(4 * np.pi * PHASE))
    (joint,) = of_cycles(residual[:, :, None])  # type: ignore[misc]
    assert joint.trend is not None
    assert joint.trend.significant
    assert joint.trend.pattern == pattern
    assert joint.noise == pytest.approx(1.0, abs=0.15)
    assert joint.trend.mean_square == pytest.approx(np.var(profile), abs=0.1)
    assert joint.changing == pytest.approx(np.var(profile), abs=0.1)


def test_p_value_distinguishes_a_repeating_part_from_chance() -> None:
    rng = np.random.default_rng(0)
    chance = [of_cycles(noise(rng, 4)[:, :, None])[0].repeating_p for _ in range(200)]  # type: ignore[index]
    assert 2 <= sum(p < 0.05 for p in chance) <= 30
    (joint,) = of_cycles((noise(rng, 4, 0.2) + np.sin(2 * np.pi * PHASE))[:, :, None])  # type: ignore[misc]
    assert joint.repeating_p < 1e-6
    assert joint.above_noise == pytest.approx(1 / 3, abs=0.1)


def test_one_cycle_gives_no_statistics() -> None:
    assert of_cycles(np.ones((1, 20, 3))) is None
    residual = np.ones((2, 20, 1))
    residual[0, 10:] = residual[1, :10] = np.nan
    assert of_cycles(residual) is None


def test_without_noise_there_is_no_significant_trend() -> None:
    (joint,) = of_cycles(np.tile(PHASE, (4, 1))[:, :, None])  # type: ignore[misc]
    assert joint.noise == pytest.approx(0.0, abs=1e-20)
    assert joint.above_noise == pytest.approx(1.0)
    assert joint.trend is not None
    assert not joint.trend.significant


def prepare_parallel(recording: Recording, cutoff: float) -> PreparedRecording:
    return prepare(recording, "parallel", cutoff)


@pytest.mark.parametrize("cutoff", [30, 37, 24])  # 4, 3, 5 samples to a row; 2000 to a cycle
def test_rows_of_equal_phase_are_aligned(make: Callable[..., Recording], cutoff: float) -> None:
    prepared = prepare_parallel(make(cycles=4), cutoff)
    table = by_cycle(prepared, prepared.torque)
    period = prepared.recording.run.period
    assert table.shape[0] == 4
    assert abs(table.shape[1] - period * prepared.rate) < 1
    spread = np.nanstd(table, axis=0)
    assert np.isfinite(table).mean() > 0.99
    assert np.nanmax(spread) < 2e-3 * np.nanstd(table)


def test_gaps_remain_gaps(make: Callable[..., Recording]) -> None:
    recording = make(cycles=3)
    recording.voltage[2600:2640, 1] = np.nan
    prepared = prepare_parallel(recording, 30)
    table = by_cycle(prepared, prepared.torque)
    assert np.isnan(table).any(axis=(0, 1)).tolist() == [False, True, False]
    np.testing.assert_allclose(table[1][np.isfinite(table[1])], table[0][np.isfinite(table[1])], atol=1e-3)


def test_cycles_are_aligned_when_the_motion_pauses(make: Callable[..., Recording]) -> None:
    recording = make(cycles=3)
    after_pause = np.arange(len(recording.time)) >= 3100
    paused = replace(recording, time=recording.time + 7 * after_pause / recording.run.rate)
    prepared = prepare_parallel(paused, 30)
    table = by_cycle(prepared, prepared.torque)
    assert np.nanmax(np.nanstd(table, axis=0)) < 2e-3 * np.nanstd(table)


def test_cycles_are_aligned_when_samples_are_lost(make: Callable[..., Recording]) -> None:
    recording = make(cycles=3)
    received = np.delete(np.arange(len(recording.time)), np.r_[2480:2520, 3300])  # across the end of the first cycle
    shorter = replace(
        recording, **{name: getattr(recording, name)[received] for name in ("time", "position", "voltage", "repeat")}
    )
    prepared = prepare_parallel(shorter, 30)
    table = by_cycle(prepared, prepared.torque)
    assert np.nanmax(np.nanstd(table, axis=0)) < 2e-3 * np.nanstd(table)


def test_simulated_voltage_noise_is_recovered(make: Callable[..., Recording], truth: Floats) -> None:
    prepared = prepare_parallel(make(cycles=4, noise=0.02), 30)
    exact = prepare_parallel(make(cycles=4), 30)
    added = prepared.torque - exact.torque
    statistics = of_residuals([prepared], [prepared.torque - prepared.regressor @ truth])
    assert statistics is not None
    for joint, rms in zip(statistics, np.sqrt(np.nanmean(added**2, axis=0)), strict=True):
        assert joint.noise_rms == pytest.approx(rms, rel=0.08)
        assert joint.above_noise < 0.08


def test_a_motion_without_cycles_gives_no_statistics(make: Callable[..., Recording]) -> None:
    recording = make(cycles=2)
    prepared = prepare_parallel(replace(recording, repeat=np.full_like(recording.repeat, -1)), 30)
    assert of_residuals([prepared], [prepared.torque]) is None


@pytest.mark.parametrize(("same", "expected"), [(True, 1.0), (False, 0.0)])
def test_share_of_the_finest_part_that_repeats(same: bool, expected: float) -> None:
    """Errors of the positions are the same in every cycle, or different."""
    recording = building.record(cycles=5)
    rows = round(building.PERIOD * building.RATE)
    rng = np.random.default_rng(0)
    error = np.tile(rng.normal(size=(rows, 1)), (5, 1)) if same else rng.normal(size=(5 * rows, 1))
    recording.position[:] += 1e-3 * error
    assert repeating_share(building.prepared(recording)) == pytest.approx([expected], abs=0.05)


def test_half_of_the_power_repeats() -> None:
    recording = building.record(cycles=6)
    rows = round(building.PERIOD * building.RATE)
    rng = np.random.default_rng(1)
    recording.position[:] += 1e-3 * (np.tile(rng.normal(size=(rows, 1)), (6, 1)) + rng.normal(size=(6 * rows, 1)))
    assert repeating_share(building.prepared(recording)) == pytest.approx([0.5], abs=0.05)


def test_all_may_repeat_where_nothing_is_repeated() -> None:
    assert repeating_share(building.prepared(building.record(cycles=1))) == pytest.approx([1.0])
