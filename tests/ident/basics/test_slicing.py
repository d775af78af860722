"""Cutting and joining data along time."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from ident.basics.slicing import along_time, concatenated


@dataclass(frozen=True, eq=False)
class Inner:
    signal: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outer:
    time: NDArray[np.float64]
    inner: Inner
    extra: dict[str, NDArray[np.float64]]
    rate: float


@pytest.mark.parametrize("index", [slice(2, 5), np.array([0, 3]), np.arange(6) > 2], ids=["slice", "indices", "mask"])
def test_all_arrays_are_cut_alike_and_other_values_are_kept(index: slice | NDArray[np.int64]) -> None:
    time = np.arange(6.0)
    data = Outer(time, Inner(np.stack([time, -time], axis=1)), {"load": 2 * time}, 500.0)
    cut = along_time(data, index)
    expected = time[index]
    np.testing.assert_array_equal(cut.time, expected)
    np.testing.assert_array_equal(cut.inner.signal, np.stack([expected, -expected], axis=1))
    np.testing.assert_array_equal(cut.extra["load"], 2 * expected)
    assert cut.rate == 500.0
    assert len(data.time) == 6


def test_parts_that_were_cut_are_joined_again() -> None:
    time = np.arange(6.0)
    data = Outer(time, Inner(time[:, None]), {"load": 2 * time, "rest": time}, 500.0)
    first, second = (along_time(data, part) for part in (slice(2), slice(2, None)))
    del second.extra["rest"]
    whole = concatenated([first, second])
    np.testing.assert_array_equal(whole.time, time)
    np.testing.assert_array_equal(whole.inner.signal, time[:, None])
    assert whole.extra.keys() == {"load"}
    assert whole.rate == 500.0
    assert concatenated([None, time]) is None
