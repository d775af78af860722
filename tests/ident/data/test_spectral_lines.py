"""Vibrations are distinguished from noise."""

from collections.abc import Callable

import numpy as np
import pytest

from ident import filters
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data.spectral_lines import strongest_lines
from recordings.recording import Recording


@pytest.fixture(scope="module")
def prepared(make: Callable[..., Recording]) -> PreparedRecording:
    recording = make(cycles=3)
    return prepare(recording, "parallel", 30.0)


def _noise(prepared: PreparedRecording, seed: int) -> np.ndarray:
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
    assert first is None
    assert third is None
    assert second is not None
    assert second.frequency == pytest.approx(frequency, abs=0.05)
    assert second.mean_square == pytest.approx(0.5, rel=0.3)


def test_transient_is_no_vibration(make: Callable[..., Recording]) -> None:
    """Three seconds of it, at half of the recording."""
    prepared = prepare(make(cycles=6), "parallel", 30.0)
    since = prepared.time - prepared.time.mean()
    residual = _noise(prepared, 2)
    residual[:, 1] += 3 * np.sin(2 * np.pi * 7.37 * since) * np.where((since > 0) & (since < 3), 1.0, 0.0)
    assert strongest_lines([prepared], [residual]) == (None, None, None)


def test_broad_peak_is_no_vibration(prepared: PreparedRecording) -> None:
    """Noise in a band of 1 Hz."""
    white = np.random.default_rng(3).normal(size=len(prepared.time))
    slow = filters.convolve(white, filters.low_pass(0.5, prepared.rate))
    residual = _noise(prepared, 2)
    residual[:, 1] += 3 * np.nan_to_num(slow / np.nanstd(slow)) * np.sin(2 * np.pi * 9.0 * prepared.time)
    assert strongest_lines([prepared], [residual])[1] is None
