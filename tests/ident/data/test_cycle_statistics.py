"""Synthetic residuals: a repeating waveform, autocorrelated noise and, in some tests, a trend."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Generator
from scipy.signal import lfilter

from ident.data.cycle_statistics import by_cycle, of_cycles, of_residuals, repeating_share
from ident.data.prepared_recording import prepare
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


def test_statistics_take_two_cycles_with_common_rows() -> None:
    assert of_cycles(np.ones((1, 20, 3))) is None
    residual = np.ones((2, 20, 1))
    residual[0, 10:] = residual[1, :10] = np.nan
    assert of_cycles(residual) is None
    (joint,) = of_cycles(np.tile(PHASE, (4, 1))[:, :, None])  # type: ignore[misc]
    assert joint.noise == pytest.approx(0.0, abs=1e-20)
    assert joint.above_noise == pytest.approx(1.0)
    assert joint.trend is not None
    assert not joint.trend.significant


def paused(recording: Recording) -> Recording:
    """The motion rests for 7 s in its second cycle."""
    after = np.arange(len(recording.time)) >= 3100
    return replace(recording, time=recording.time + 7 * after / recording.run.rate)


def with_losses(recording: Recording) -> Recording:
    """Samples are lost across the end of the first cycle, and one later."""
    received = np.delete(np.arange(len(recording.time)), np.r_[2480:2520, 3300])
    signals = ("time", "position", "voltage", "repeat")
    return replace(recording, **{name: getattr(recording, name)[received] for name in signals})


@pytest.mark.parametrize(
    ("cutoff", "change"),
    # 4, 3, 5 samples to a row; 2000 to a cycle
    [(30, None), (37, None), (24, None), (30, paused), (30, with_losses)],
)
def test_rows_of_equal_phase_are_aligned(
    make: Callable[..., Recording], cutoff: float, change: Callable[[Recording], Recording] | None
) -> None:
    recording = make(cycles=3)
    prepared = prepare(change(recording) if change else recording, "parallel", cutoff)
    table = by_cycle(prepared, prepared.torque)
    assert table.shape[0] == 3
    assert abs(table.shape[1] - prepared.recording.run.period * prepared.rate) < 1
    assert np.nanmax(np.nanstd(table, axis=0)) < 2e-3 * np.nanstd(table)
    assert np.isfinite(table).mean() > (0.9 if change else 0.99)


def test_gaps_remain_gaps(make: Callable[..., Recording]) -> None:
    recording = make(cycles=3)
    recording.voltage[2600:2640, 1] = np.nan
    prepared = prepare(recording, "parallel", 30)
    table = by_cycle(prepared, prepared.torque)
    assert np.isnan(table).any(axis=(0, 1)).tolist() == [False, True, False]
    np.testing.assert_allclose(table[1][np.isfinite(table[1])], table[0][np.isfinite(table[1])], atol=1e-3)


def test_simulated_voltage_noise_is_recovered(make: Callable[..., Recording], truth: Floats) -> None:
    noisy, exact = (prepare(make(cycles=4, noise=volts), "parallel", 30) for volts in (0.02, 0.0))
    statistics = of_residuals([noisy], [noisy.torque - noisy.regressor @ truth])
    assert statistics is not None
    added = np.sqrt(np.nanmean((noisy.torque - exact.torque) ** 2, axis=0))
    assert [joint.noise_rms for joint in statistics] == pytest.approx(added.tolist(), rel=0.08)
    assert all(joint.above_noise < 0.08 for joint in statistics)
    unmarked = replace(noisy.recording, repeat=np.full_like(noisy.recording.repeat, -1))
    without_cycles = prepare(unmarked, "parallel", 30)
    assert of_residuals([without_cycles], [without_cycles.torque]) is None


@pytest.mark.parametrize(
    ("cycles", "repeated", "different", "share"),
    [(5, 1, 0, 1.0), (5, 0, 1, 0.0), (6, 1, 1, 0.5), (1, 1, 1, 1.0)],
)
def test_share_of_the_finest_part_that_repeats(cycles: int, repeated: int, different: int, share: float) -> None:
    """Errors of the positions are the same in every cycle, or different; a single cycle may repeat completely."""
    recording = building.record(cycles=cycles)
    rows, rng = round(building.PERIOD * building.RATE), np.random.default_rng(0)
    same, other = np.tile(rng.normal(size=(rows, 1)), (cycles, 1)), rng.normal(size=(cycles * rows, 1))
    recording.position[:] += 1e-3 * (repeated * same + different * other)
    assert repeating_share(building.prepared(recording)) == pytest.approx([share], abs=0.05)
