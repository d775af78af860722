"""Sine waves in a residual: periodograms, peaks and least squares."""

import numpy as np
import pytest

from ident.diagnosis.ripple.waves import highest_peaks, is_significant, least_squares, slope, wave, wave_numbers

ANGLE = np.sort(np.random.default_rng(1).uniform(-1.0, 1.0, 4000))


def test_highest_peak_is_the_wave() -> None:
    signal = np.sin(120.0 * ANGLE) + np.random.default_rng(2).normal(size=len(ANGLE))
    peaks = highest_peaks(ANGLE, signal, wave_numbers(ANGLE, 500.0))
    assert peaks[0] == pytest.approx(120.0, abs=0.8)


def test_grid_begins_with_one_period_over_the_coordinate() -> None:
    assert wave_numbers(ANGLE, 100.0)[0] == pytest.approx(2 * np.pi / np.ptp(ANGLE))
    assert wave_numbers(ANGLE, 100.0, lowest=20.0)[0] == 20.0


@pytest.mark.parametrize("seed", range(20))
def test_noise_has_no_significant_wave(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=len(ANGLE))
    grid = wave_numbers(ANGLE, 500.0)
    for peak in highest_peaks(ANGLE, noise, grid):
        columns = wave(ANGLE, peak)
        rest = noise - columns @ least_squares(columns, noise)
        assert not is_significant(peak, float(noise @ noise - rest @ rest), ANGLE, rest, grid)


def test_slope_is_the_derivative_by_the_wave_number() -> None:
    step = 1e-5
    pair = np.array([0.3, -0.7])
    difference = (wave(ANGLE, 50.0 + step) - wave(ANGLE, 50.0 - step)) @ pair / (2 * step)
    np.testing.assert_allclose(slope(ANGLE, wave(ANGLE, 50.0), *pair), difference, atol=1e-6)


def test_columns_of_zeros_have_the_coefficient_zero() -> None:
    matrix = np.stack([ANGLE, np.zeros_like(ANGLE)], axis=1)
    np.testing.assert_allclose(least_squares(matrix, 2 * ANGLE), [2.0, 0.0], atol=1e-12)
