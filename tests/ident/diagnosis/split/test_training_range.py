"""The range of a signal in the training rows."""

import numpy as np

from ident.diagnosis.split.training_range import outside_of_range, training_range


def test_range_is_that_of_the_training_rows_of_all_recordings() -> None:
    signals = [np.array([[0.0, 5.0], [1.0, 6.0], [9.0, 7.0]]), np.array([[-1.0, 8.0]])]
    train = [np.array([[True, False], [True, False], [False, False]]), np.array([[True, False]])]
    low, high = training_range(signals, train)
    np.testing.assert_array_equal(low, [-1.0, np.nan])
    np.testing.assert_array_equal(high, [1.0, np.nan])


def test_rows_may_exceed_the_range_a_little_and_are_never_outside_of_an_unknown_one() -> None:
    signal = np.array([[-0.05, 1.0], [-0.01, 1.0], [1.01, 1.0], [1.05, 1.0]])
    (outside,) = outside_of_range([signal], np.array([0.0, np.nan]), np.array([1.0, np.nan]))
    np.testing.assert_array_equal(outside, [[True, False], [False, False], [False, False], [True, False]])
