"""The soft move to the start of a trajectory."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.rig import Limits
from trajectories import approach

joints = st.tuples(*[st.floats(-1.2, 1.4)] * 3).map(np.array)


@given(start=joints, goal=joints, rate=st.sampled_from([200.0, 500.0, 1000.0]))
@settings(max_examples=50, deadline=None)
def test_approach_moves_gently_from_rest_to_rest(start: np.ndarray, goal: np.ndarray, rate: float) -> None:
    path = approach(start, goal, Limits(), rate)
    assert (path[0] == start).all()
    assert (path[-1] == goal).all()
    steps = np.diff(path, axis=0, prepend=path[:1], append=path[-1:]) * rate
    assert np.abs(steps).max() <= 1.0 + 1e-9
    assert np.abs(np.diff(steps, axis=0)).max() * rate <= 4.0 * 1.01 + 1e-6


def test_approach_reaches_the_gentle_speed() -> None:
    path = approach(np.zeros(3), np.array([2.0, 0, 0]), Limits(), 500.0)
    assert np.abs(np.diff(path, axis=0)).max() * 500 == pytest.approx(1.0, rel=0.01)


def test_approach_keeps_half_of_tight_limits() -> None:
    path = approach(np.zeros(3), np.array([1.0, -0.5, 0]), Limits(speed=0.4, acceleration=1.0), 500.0)
    steps = np.diff(path, axis=0) * 500
    assert np.abs(steps).max() <= 0.2 + 1e-9


def test_approach_from_the_goal_has_one_row() -> None:
    here = np.array([0.1, 0.2, 0.3])
    assert approach(here, here, Limits(), 500.0).tolist() == [here.tolist()]


def test_unknown_position_is_refused() -> None:
    with pytest.raises(BadInput, match="finite joint angles expected"):
        approach(np.array([0, np.nan, 0]), np.zeros(3), Limits(), 500.0)
