"""A trend has few points however long it is, and they have the mean of all nights."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.fleet.thinned_series import POINTS, ThinnedSeries


@given(st.integers(1, 20 * POINTS))
def test_trend_is_thinned_and_keeps_its_mean(nights: int) -> None:
    trend = ThinnedSeries("parameter", 1, "N m")
    for night in range(nights):
        trend.add(0, float(night), float(night % 7), 0.1)
    day, value, half, count = np.array(trend.points[0]).T
    assert min(nights, POINTS // 2) <= len(day) <= POINTS
    assert count.sum() == nights
    assert (np.diff(day) > 0).all()
    assert (value * count).sum() == pytest.approx(sum(night % 7 for night in range(nights)))
    assert half == pytest.approx(np.full(len(half), 0.1))
