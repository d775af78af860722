"""The soft move to the start of a trajectory."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from recordings.rig import Limits
from trajectories import approach

joints = st.tuples(*[st.floats(-1.2, 1.4)] * 3).map(np.array)


@given(
    start=joints,
    goal=joints,
    rate=st.sampled_from([200.0, 500.0, 1000.0]),
    limits=st.sampled_from([Limits(), Limits(speed=2.0, acceleration=8.0), Limits(speed=0.4, acceleration=1.0)]),
)
@settings(max_examples=50, deadline=None)
@example(start=np.zeros(3), goal=np.zeros(3), rate=500.0, limits=Limits())
def test_approach_moves_gently_from_rest_to_rest_and_keeps_half_of_tight_limits(
    start: np.ndarray, goal: np.ndarray, rate: float, limits: Limits
) -> None:
    path = approach(start, goal, limits, rate)
    speed, acceleration = min(1.0, limits.speed / 2), min(4.0, limits.acceleration / 2)
    assert (len(path) == 1) == (start == goal).all()
    assert (path[0] == start).all()
    assert (path[-1] == goal).all()
    steps = np.diff(path, axis=0, prepend=path[:1], append=path[-1:]) * rate
    assert np.abs(steps).max() <= speed + 1e-9
    assert np.abs(np.diff(steps, axis=0)).max() * rate <= 1.01 * acceleration + 1e-6


def test_approach_reaches_the_gentle_speed() -> None:
    path = approach(np.zeros(3), np.array([2.0, 0, 0]), Limits(), 500.0)
    assert np.abs(np.diff(path, axis=0)).max() * 500 == pytest.approx(1.0, rel=0.01)
