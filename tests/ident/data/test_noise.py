from collections.abc import Callable

import numpy as np
import pytest

from ident.data.noise import estimate, residual_std
from ident.data.prepared_recording import PreparedRecording, prepare
from recordings.recording import Floats, Recording

VOLTS = 0.02
BAND = np.sqrt(2 * 30 / 500)
"""Amplitude ratio of white noise that the low-pass at 30 Hz leaves at 500 Hz."""


def prepared_with_residual(recording: Recording, truth: Floats) -> tuple[PreparedRecording, Floats]:
    prepared = prepare(recording, "parallel", None)
    return prepared, prepared.torque - prepared.regressor @ truth


@pytest.mark.parametrize("cycles", [1, 2, 5])
def test_planted_voltage_noise_is_found(make: Callable[..., Recording], truth: Floats, cycles: int) -> None:
    prepared, residuals = prepared_with_residual(make(cycles=cycles, noise=VOLTS), truth)
    for joint_noise in estimate([prepared], [residuals]):
        assert joint_noise.source == ("repetition" if cycles > 1 else "band above the signal")
        assert joint_noise.volts == pytest.approx(VOLTS * BAND, rel=0.15)
        assert joint_noise.floor < 0.02


def test_noise_that_does_not_depend_on_the_voltage_is_a_floor(make: Callable[..., Recording], truth: Floats) -> None:
    prepared, residuals = prepared_with_residual(make(cycles=8, noise=VOLTS), truth)
    residuals += np.random.default_rng(0).normal(0, 0.05, prepared.torque.shape)
    for joint_noise in estimate([prepared], [residuals]):
        assert joint_noise.volts == pytest.approx(VOLTS * BAND, rel=0.15)
        assert joint_noise.floor == pytest.approx(0.05, rel=0.15)


def test_standard_deviation_follows_the_voltage(make: Callable[..., Recording], truth: Floats) -> None:
    prepared, residuals = prepared_with_residual(make(cycles=5, noise=VOLTS), truth)
    std = residual_std(prepared, residuals, estimate([prepared], [residuals]))
    normalised = (residuals / std)[np.isfinite(residuals)]
    assert normalised.std() == pytest.approx(1.0, abs=0.05)
    quiet = prepared.volt_sensitivity < np.nanmedian(prepared.volt_sensitivity)
    for rows in (quiet, ~quiet):
        assert np.nanstd((residuals / std)[rows]) == pytest.approx(1.0, abs=0.15)
    nothing = 0 * residuals  # without noise, it is still positive
    assert np.nanmin(residual_std(prepared, nothing, estimate([prepared], [nothing]))) > 0


def test_model_errors_raise_the_standard_deviation(make: Callable[..., Recording], truth: Floats) -> None:
    prepared, residuals = prepared_with_residual(make(cycles=3, noise=VOLTS), truth)
    residuals += np.cos(2 * np.pi * prepared.phase)[:, None]
    noise = estimate([prepared], [residuals])
    assert noise[0].volts == pytest.approx(VOLTS * BAND, rel=0.15)
    std = residual_std(prepared, residuals, noise)
    assert np.nanmin(std) > 0.6
    assert np.nanmean(residuals**2) == pytest.approx(np.nanmean(std**2), rel=0.1)


def test_ripple_at_high_harmonics_is_not_counted_as_noise(make: Callable[..., Recording], truth: Floats) -> None:
    recording = make(cycles=1, noise=VOLTS)
    recording.voltage[:] += 0.3 * np.sin(2 * np.pi * 75.0 * recording.time)[:, None]
    prepared, residuals = prepared_with_residual(recording, truth)
    for joint_noise in estimate([prepared], [residuals]):
        assert joint_noise.volts == pytest.approx(VOLTS * BAND, rel=0.2)
