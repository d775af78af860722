from collections.abc import Callable

import numpy as np
import pytest

from ident.data.dataset import Dataset, build
from ident.data.noise import estimate, residual_std
from ident.dynamics import mechanisms
from recordings.recording import Floats, Recording

VOLTS = 0.02
BAND = np.sqrt(2 * 30 / 500)
"""Share of white noise that the low-pass at 30 Hz leaves at 500 Hz."""


def prepared(recording: Recording) -> Dataset:
    return build(recording, mechanisms.create(recording.rig), "parallel", None)


def residual(dataset: Dataset, truth: Floats) -> Floats:
    return dataset.torque - dataset.regressor @ truth


@pytest.mark.parametrize("cycles", [1, 2, 5])
def test_planted_voltage_noise_is_found(make: Callable[..., Recording], truth: Floats, cycles: int) -> None:
    dataset = prepared(make(cycles=cycles, noise=VOLTS))
    for joint in estimate([dataset], [residual(dataset, truth)]):
        assert joint.source == ("repetition" if cycles > 1 else "band above the signal")
        assert joint.volts == pytest.approx(VOLTS * BAND, rel=0.15)
        assert joint.floor < 0.02


def test_noise_that_does_not_come_from_the_voltage_is_a_floor(make: Callable[..., Recording], truth: Floats) -> None:
    dataset = prepared(make(cycles=8, noise=VOLTS))
    left = residual(dataset, truth) + np.random.default_rng(0).normal(0, 0.05, dataset.torque.shape)
    for joint in estimate([dataset], [left]):
        assert joint.volts == pytest.approx(VOLTS * BAND, rel=0.15)
        assert joint.floor == pytest.approx(0.05, rel=0.15)


def test_the_spread_follows_the_voltage(make: Callable[..., Recording], truth: Floats) -> None:
    dataset = prepared(make(cycles=5, noise=VOLTS))
    left = residual(dataset, truth)
    std = residual_std(dataset, left, estimate([dataset], [left]))
    even = (left / std)[np.isfinite(left)]
    assert even.std() == pytest.approx(1.0, abs=0.05)
    quiet = dataset.volt_sensitivity < np.nanmedian(dataset.volt_sensitivity)
    for half in (quiet, ~quiet):
        assert np.nanstd((left / std)[half]) == pytest.approx(1.0, abs=0.15)


def test_what_the_model_lacks_raises_the_floor(make: Callable[..., Recording], truth: Floats) -> None:
    dataset = prepared(make(cycles=3, noise=VOLTS))
    left = residual(dataset, truth) + np.cos(2 * np.pi * dataset.phase)[:, None]
    noise = estimate([dataset], [left])
    assert noise[0].volts == pytest.approx(VOLTS * BAND, rel=0.15)
    std = residual_std(dataset, left, noise)
    assert np.nanmin(std) > 0.6
    assert np.nanmean(left**2) == pytest.approx(np.nanmean(std**2), rel=0.1)


def test_without_any_noise_every_sample_still_has_a_finite_spread(recording: Recording, truth: Floats) -> None:
    dataset = prepared(recording)
    left = 0 * residual(dataset, truth)
    std = residual_std(dataset, left, estimate([dataset], [left]))
    assert (std[np.isfinite(dataset.torque)] > 0).all()


def test_ripple_at_high_harmonics_is_no_noise(make: Callable[..., Recording], truth: Floats) -> None:
    recording = make(cycles=1, noise=VOLTS)
    recording.voltage[:] += 0.3 * np.sin(2 * np.pi * 75.0 * recording.time)[:, None]
    dataset = prepared(recording)
    for joint in estimate([dataset], [residual(dataset, truth)]):
        assert joint.volts == pytest.approx(VOLTS * BAND, rel=0.2)
