"""Vibrations are distinguished from noise."""

from collections.abc import Callable

import numpy as np
import pytest

from ident import filters
from ident.data.dataset import Dataset, build
from ident.data.spectral_lines import strongest_lines
from ident.dynamics import mechanisms
from recordings.recording import Recording


@pytest.fixture(scope="module")
def dataset(make: Callable[..., Recording]) -> Dataset:
    recording = make(cycles=3)
    return build(recording, mechanisms.create(recording.rig), "parallel", 30.0)


def _noise(dataset: Dataset, seed: int) -> np.ndarray:
    taps = filters.low_pass(30.0, dataset.rate)
    white = np.random.default_rng(seed).normal(size=(len(dataset.time), 3))
    low_passed = filters.convolve(white, taps)
    return np.where(np.isfinite(dataset.torque), low_passed / np.nanstd(low_passed), np.nan)


def test_noise_has_no_lines(dataset: Dataset) -> None:
    lines = [strongest_lines([dataset], [_noise(dataset, seed)]) for seed in range(40)]
    assert not any(line for joints in lines for line in joints)


@pytest.mark.parametrize("frequency", [3.3, 7.37, 18.2])
def test_a_vibration_is_found_with_its_frequency_and_mean_square(dataset: Dataset, frequency: float) -> None:
    vibration = np.sin(2 * np.pi * frequency * dataset.time + 0.3)
    residual = _noise(dataset, 1)
    residual[:, 1] += vibration
    first, second, third = strongest_lines([dataset], [residual])
    assert first is None
    assert third is None
    assert second is not None
    assert second.frequency == pytest.approx(frequency, abs=0.05)
    assert second.mean_square == pytest.approx(0.5, rel=0.3)
