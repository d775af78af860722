"""Sine waves in a residual: periodograms, peaks and least squares."""

import numpy as np
import pytest

from ident.diagnosis.ripple.high_band import HighBand
from ident.diagnosis.ripple.waves import Carrier, JointSignal, least_squares, wave_numbers
from recordings.recording import Floats

ANGLE = np.sort(np.random.default_rng(1).uniform(-1.0, 1.0, 4000))
NONE = np.zeros(wave_numbers(ANGLE, 500.0).shape, bool)


def _carrier(residual: Floats) -> Carrier:
    """Waves over the angle in a recording at 1 kHz whose low-pass is at 5 Hz."""
    column, rows = np.ones((len(ANGLE), 1)), np.ones((len(ANGLE), 1), bool)
    band = HighBand(
        np.arange(len(ANGLE)) / 1000.0,
        ANGLE[:, None],
        column,
        column,
        residual[:, None],
        rows,
        ~rows,
        1000.0,
        5.0,
        None,
        1,
    )
    return JointSignal([band], 0).over_angle


def test_highest_peak_is_the_wave_and_is_refined() -> None:
    signal = np.sin(120.0 * ANGLE) + np.random.default_rng(2).normal(size=len(ANGLE))
    carrier = _carrier(signal)
    (highest, *_) = carrier.peaks(signal, wave_numbers(ANGLE, 500.0), NONE)
    assert highest == pytest.approx(120.0, abs=0.8)
    assert carrier.refined(highest, signal) == pytest.approx(120.0, abs=0.2)


def test_excluded_peaks_are_no_candidates() -> None:
    signal = np.sin(120.0 * ANGLE) + np.random.default_rng(2).normal(size=len(ANGLE))
    grid = wave_numbers(ANGLE, 500.0)
    excluded = np.abs(grid - 120.0) < 30.0
    assert all(abs(peak - 120.0) > 29.0 for peak in _carrier(signal).peaks(signal, grid, excluded))


def test_grid_begins_with_one_period_over_the_coordinate() -> None:
    assert wave_numbers(ANGLE, 100.0)[0] == pytest.approx(2 * np.pi / np.ptp(ANGLE))
    assert wave_numbers(ANGLE, 100.0, lowest=20.0)[0] == 20.0


@pytest.mark.parametrize("seed", range(20))
def test_noise_has_no_significant_wave(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=len(ANGLE))
    grid, carrier = wave_numbers(ANGLE, 500.0), _carrier(noise)
    for peak in carrier.peaks(noise, grid, NONE):
        change = carrier.fitted(carrier.columns(peak), noise)
        rest = noise - change
        assert not carrier.is_significant(peak, float(noise @ noise - rest @ rest), rest, grid)


def test_slope_is_the_derivative_by_the_wave_number() -> None:
    step, order, carrier = 1e-3, 120.0, _carrier(ANGLE)
    target = carrier.columns(order) @ [0.3, -0.7]
    slope, left = carrier.slope(order, target)
    np.testing.assert_allclose(left, 0.0, atol=1e-9)
    _, shifted = carrier.slope(order + step, target)
    np.testing.assert_allclose(-shifted / step, slope, atol=1e-2)


def test_columns_of_zeros_have_the_coefficient_zero() -> None:
    matrix = np.stack([ANGLE, np.zeros_like(ANGLE)], axis=1)
    np.testing.assert_allclose(least_squares(matrix, 2 * ANGLE), [2.0, 0.0], atol=1e-12)
