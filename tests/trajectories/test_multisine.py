import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.rig import Axis, Limits, Rig, simulated_rig
from trajectories.multisine import HIGHEST, PERIOD, lines, multisine


@given(st.sampled_from([100.0, 250.0, 500.0, 1000.0]))
def test_lines_are_whole_multiples_between_which_there_is_room(rate: float) -> None:
    multiples = lines(rate) * PERIOD
    assert np.array_equal(multiples, np.rint(multiples))
    assert np.all(np.diff(multiples) >= 1)
    assert multiples[-1] <= HIGHEST * rate * PERIOD
    assert len(multiples) < 0.1 * multiples[-1]


@settings(max_examples=10)
@given(joint=st.integers(1, 3), amplitude=st.floats(1e-3, 0.1), acceleration=st.floats(10, 300))
def test_one_joint_moves_within_its_limits(joint: int, amplitude: float, acceleration: float) -> None:
    rig = simulated_rig().model_copy(update={"limits": Limits(acceleration=acceleration)})
    position, velocity, bend = multisine(rig, joint, amplitude).sample(np.arange(0, PERIOD, 1 / rig.rate))
    others = [j for j in range(3) if j != joint - 1]
    assert not np.ptp(position[:, others], axis=0).any()
    assert np.ptp(position[:, joint - 1]) > 0
    assert np.abs(position[:, joint - 1] - position[0, others[0]]).max() <= amplitude * 1.01
    assert np.abs(velocity).max() <= rig.limits.speed
    assert np.abs(bend).max() <= 0.71 * acceleration


def test_derivatives_are_those_of_the_position() -> None:
    time = np.arange(0, 1, 1e-4)
    position, velocity, acceleration = multisine(simulated_rig(), 2, 0.01).sample(time)
    assert np.gradient(position[:, 1], time)[1:-1] == pytest.approx(velocity[1:-1, 1], abs=2e-3)
    assert np.gradient(velocity[:, 1], time)[1:-1] == pytest.approx(acceleration[1:-1, 1], abs=2.0)


def test_single_axes_move_about_zero() -> None:
    rig = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis()))
    position, _, _ = multisine(rig, 2, 0.01).sample(np.arange(0, PERIOD, 1e-3))
    assert np.abs(position).max() <= 0.0101
