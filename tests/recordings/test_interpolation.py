"""Linear interpolation of signals with gaps."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from recordings.interpolation import interpolate, interpolate_columns, interpolate_within_gaps

TIME = np.arange(6.0)


@given(
    st.lists(st.booleans(), min_size=6, max_size=6).filter(any),
    st.lists(st.floats(-2.0, 8.0), min_size=1, max_size=9),
)
def test_a_line_is_met_whatever_is_missing_and_held_outside(known: list[bool], instants: list[float]) -> None:
    at = np.array(instants)
    inside = np.clip(at, TIME[known].min(), TIME[known].max())
    signal = np.where(known, 3 * TIME - 1, np.nan)
    np.testing.assert_allclose(interpolate(at, TIME, signal), 3 * inside - 1, atol=1e-12)


def test_samples_without_a_time_are_passed_over() -> None:
    time = np.where(TIME == 2, np.nan, TIME)
    signal = np.where(TIME == 2, 99.0, TIME)
    np.testing.assert_allclose(interpolate(TIME, time, signal), TIME)


def test_columns_are_interpolated_each_by_itself() -> None:
    values = np.column_stack([TIME, np.full(6, np.nan), np.where(TIME == 3, np.nan, TIME**0)])
    columns = interpolate_columns(np.array([0.5, 3.0]), TIME.astype(int), values)
    np.testing.assert_allclose(columns, [[0.5, np.nan, 1.0], [3.0, np.nan, 1.0]])


def test_nothing_is_known_in_a_gap_and_beyond_the_ends() -> None:
    time = np.concatenate([np.arange(10), np.arange(20, 30)]).astype(float)
    instants = np.arange(-3, 33.0)
    found = interpolate_within_gaps(instants, time, 2 * time)
    known = np.isin(instants, [-1, *time, 30])
    np.testing.assert_array_equal(np.isfinite(found), known)
    np.testing.assert_array_equal(found[np.isin(instants, time)], 2 * time)
    assert np.isnan(interpolate_within_gaps(instants, time[:0], time[:0])).all()
