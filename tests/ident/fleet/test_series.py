"""Rows become series: sorted by time, motions told apart, gaps kept."""

import numpy as np

from ident.fleet.series import logarithmic, motion_number
from tests.ident.fleet.conftest import rows_of, series_of


def test_series_are_sorted_by_time_and_keep_gaps() -> None:
    values = np.array([1.0, np.nan, 3.0, 4.0])
    made = rows_of("r02", {"c_c1": values}, temperature=np.array([20.0, 21.0, 22.0, 23.0])) + rows_of(
        "r01", {"c_c2": values[:2]}
    )
    nights, series = series_of(made[::-1])
    assert [each.robot for each in nights] == ["r01", "r02"]
    (c_c1,) = (each for each in series if each.name == "c_c1")
    np.testing.assert_array_equal(c_c1.value, values)
    np.testing.assert_array_equal(c_c1.known, [True, False, True, True])
    assert c_c1.temperature[3] == 23.0
    assert c_c1.joint == 1
    assert np.allclose(np.diff(c_c1.nights.day), 1.0)


def test_quantity_that_may_be_zero_is_not_watched_by_its_logarithm() -> None:
    for values in (np.array([1.0, -1.0]), np.array([0.001, 0.002])):
        assert not logarithmic(values, np.full(2, 0.01))
    assert logarithmic(np.array([1.0, 1.1]), np.full(2, 0.01))


def test_motions_are_the_same_within_two_percent() -> None:
    features = [[4.0, 0.5, 0.1], [4.001, 0.504, 0.1], [3.0, 0.5, 0.1], [4.0, 0.5, 0.2], [4.0, 0.5]]
    known: list[list[float]] = []
    assert [motion_number(each, known) for each in features] == [0, 0, 1, 2, 3]
