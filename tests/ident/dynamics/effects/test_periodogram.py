"""Periodogram over an uneven coordinate."""

import numpy as np
import pytest

from ident.dynamics.effects.periodogram import periodogram


@pytest.mark.parametrize("frequency", [7.0, 61.0, 290.0])
def test_reduction_of_the_sum_of_squares_is_that_of_least_squares(frequency: float) -> None:
    angle = np.sort(np.random.default_rng(0).uniform(0, 3.0, 5000))
    signal = 0.7 * np.sin(frequency * angle + 0.4)
    reduction = periodogram(angle, signal, np.array([frequency, 300.0]))
    assert reduction[0] == pytest.approx(signal @ signal, rel=0.07)
