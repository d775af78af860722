"""Numbers and times of SYNCs from their arrivals, with late and missing ones."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from daq.passive.sync_line import fit_line, number_syncs

PERIOD = 2_000_000
START = 1_700_000_000_000_000_000


def arrivals(rng: np.random.Generator, index: np.ndarray, period: float, jitter: float = 1e5) -> np.ndarray:
    """Arrival times of SYNCs sent every `period` [ns], each late by an exponential jitter [ns], in order."""
    late = rng.exponential(jitter, size=len(index))
    return START + np.maximum.accumulate(np.rint(index * period + late).astype(np.int64))


@given(
    seed=st.integers(0, 10_000),
    holes=st.lists(st.tuples(st.integers(600, 2400), st.integers(1, 40)), max_size=4, unique_by=lambda hole: hole[0]),
    stalls=st.lists(st.tuples(st.integers(100, 2400), st.integers(1, 150)), max_size=4),
    drift=st.floats(-2e-4, 2e-4),
)
@settings(deadline=None, max_examples=60)
def test_missing_syncs_are_counted_and_late_ones_are_not(
    seed: int, holes: list[tuple[int, int]], stalls: list[tuple[int, int]], drift: float
) -> None:
    lost = {k for first, count in holes for k in range(first, first + count)}
    # Among SYNCs that arrive at once, the missing one cannot be identified.
    assume(not any(k in lost for first, count in stalls for k in range(first, first + count + 1)))
    index = np.array([k for k in range(3000) if k not in lost])
    arrival = arrivals(np.random.default_rng(seed), index, PERIOD * (1 + drift))
    for first, count in stalls:
        # The sender stalls; the SYNCs due in that time arrive at once afterwards.
        end = START + (first + count) * PERIOD
        due = (index >= first) & (arrival < end)
        arrival[due] = end
    arrival = np.maximum.accumulate(arrival)
    np.testing.assert_array_equal(number_syncs(arrival), index)


def test_jitter_of_half_a_period_is_not_a_missing_sync() -> None:
    rng = np.random.default_rng(0)
    index = np.arange(5000)
    arrival = START + np.maximum.accumulate(
        (index * PERIOD + rng.uniform(0, 0.8 * PERIOD, size=5000)).astype(np.int64)
    )
    np.testing.assert_array_equal(number_syncs(arrival), index)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 10])
def test_few_syncs_are_numbered_consecutively(n: int) -> None:
    np.testing.assert_array_equal(number_syncs(START + PERIOD * np.arange(n)), np.arange(n))


def test_line_fit_is_robust_to_outliers() -> None:
    rng = np.random.default_rng(1)
    index = np.delete(np.arange(10_000), slice(4000, 4500))
    period = PERIOD * (1 + 50e-6)
    arrival = arrivals(rng, index, period, 3e4)
    late = rng.choice(len(index), 300, replace=False)
    arrival[late] += rng.integers(10**6, 10**7, size=300)
    start, fitted = fit_line(arrival, index, PERIOD)
    assert fitted == pytest.approx(period, rel=1e-7)
    assert abs(start - START) < 60_000
