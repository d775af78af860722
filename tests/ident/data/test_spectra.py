"""Spectra, and what in a residual is a vibration or a trend and no noise."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy import signal

from ident.basics import filters
from ident.data import welch
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data.spectral_lines import strongest_lines
from ident.data.trends import clearest_trend
from recordings.recording import Floats, Recording


@pytest.mark.parametrize("segment", [100, 101])
@pytest.mark.parametrize("centred", [True, False])
def test_densities_are_those_of_scipy(segment: int, centred: bool) -> None:
    rng = np.random.default_rng(3)
    a = 1.0 + rng.normal(size=1030)
    b = np.convolve(a, [0.5, 0.3, 0.2], mode="same")
    transforms = [welch.transforms(x, segment, centred=centred) for x in (a, b)]
    detrend = "constant" if centred else False
    _, common = signal.csd(a, b, 250.0, nperseg=segment, detrend=detrend)
    _, power = signal.welch(a, 250.0, nperseg=segment, detrend=detrend)
    assert welch.density(*transforms, segment, 250.0) == pytest.approx(common.real, rel=1e-9, abs=1e-12)
    assert welch.density(transforms[0], transforms[0], segment, 250.0) == pytest.approx(power, rel=1e-9)


@pytest.fixture(scope="module")
def prepared(make: Callable[..., Recording]) -> PreparedRecording:
    recording = make(cycles=3)
    return prepare(recording, "parallel", 30.0)


def _noise(prepared: PreparedRecording, seed: int) -> Floats:
    taps = filters.low_pass(30.0, prepared.rate)
    white = np.random.default_rng(seed).normal(size=(len(prepared.time), 3))
    low_passed = filters.convolve(white, taps)
    return np.where(np.isfinite(prepared.torque), low_passed / np.nanstd(low_passed), np.nan)


def test_noise_has_no_lines(prepared: PreparedRecording) -> None:
    lines = [strongest_lines([prepared], [_noise(prepared, seed)]) for seed in range(40)]
    assert not any(line for joints in lines for line in joints)


@pytest.mark.parametrize("frequency", [3.3, 7.37, 18.2])
def test_a_vibration_is_found_with_its_frequency_and_mean_square(
    prepared: PreparedRecording, frequency: float
) -> None:
    vibration = np.sin(2 * np.pi * frequency * prepared.time + 0.3)
    residual = _noise(prepared, 1)
    residual[:, 1] += vibration
    first, second, third = strongest_lines([prepared], [residual])
    assert (first, third) == (None, None)
    assert second is not None
    assert second.frequency == pytest.approx(frequency, abs=0.05)
    assert second.mean_square == pytest.approx(0.5, rel=0.3)


def transient(prepared: PreparedRecording) -> Floats:
    """Three seconds of a wave, at half of the recording."""
    since = prepared.time - prepared.time.mean()
    return np.sin(2 * np.pi * 7.37 * since) * np.where((since > 0) & (since < 3), 1.0, 0.0)


def broad(prepared: PreparedRecording) -> Floats:
    """Noise in a band of 1 Hz."""
    white = np.random.default_rng(3).normal(size=len(prepared.time))
    slow = filters.convolve(white, filters.low_pass(0.5, prepared.rate))
    return np.nan_to_num(slow / np.nanstd(slow)) * np.sin(2 * np.pi * 9.0 * prepared.time)


@pytest.mark.parametrize("wave", [transient, broad])
def test_what_does_not_last_or_has_no_frequency_is_no_vibration(
    make: Callable[..., Recording], wave: Callable[[PreparedRecording], Floats]
) -> None:
    prepared = prepare(make(cycles=6), "parallel", 30.0)
    residual = _noise(prepared, 2)
    residual[:, 1] += 3 * wave(prepared)
    assert strongest_lines([prepared], [residual]) == (None, None, None)


CYCLES, PHASES = 5, 200
TIME = np.arange(CYCLES)[:, None] + np.arange(PHASES) / PHASES
SHAPE = np.sin(6 * np.pi * TIME + 1)


def white_noise(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=TIME.shape)


@pytest.mark.parametrize("instant", [0.4, 1.0, 1.72, 2.5, 3.31, 4.0, 4.6])
def test_change_at_an_instant_has_its_cycle(instant: float) -> None:
    trend, others = clearest_trend(white_noise(0) + 3 * SHAPE * (TIME >= instant), 1.0, PHASES) or (None, 0.0)
    assert trend is not None
    assert trend.significant
    whole = instant == round(instant)
    assert trend.pattern == (f"step after {round(instant)}" if whole else f"step in cycle {int(instant) + 1}")
    assert others < 2.0


def test_drift_is_linear() -> None:
    trend, others = clearest_trend(white_noise(1) + SHAPE * TIME, 1.0, PHASES) or (None, 0.0)
    assert trend is not None
    assert trend.pattern == "linear"
    assert trend.mean_square == pytest.approx(1.0, rel=0.2)  # variance of 0 to 4, times that of the shape
    assert others == pytest.approx(1.0, rel=0.2)
    for few in (white_noise(0)[:2], white_noise(0)[:, :5]):  # cycles or phases
        assert clearest_trend(few, 1.0, PHASES) is None


def test_noise_is_rarely_a_trend() -> None:
    trends = [clearest_trend(white_noise(seed), 1.0, PHASES) for seed in range(200)]
    assert sum(pair[0].significant for pair in trends if pair) <= 3
