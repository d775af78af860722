"""Jog and swing: soft, small, within the limits, from any pose."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.rig import Axis, Drive, Limits, Rig, simulated_rig
from trajectories.approach import GENTLE_ACCELERATION
from trajectories.multisine import middle_pose
from trajectories.small_moves import SWINGS, jog, swing, within_limits

RIG = simulated_rig().at_rate(100.0)
POSE = middle_pose(RIG)


@given(st.integers(1, 3), st.floats(-0.3, 0.3).filter(bool), st.floats(0.05, 0.5))
def test_jog_moves_one_joint_by_the_angle_and_no_faster(joint: int, by: float, speed: float) -> None:
    motion = jog(RIG, POSE, joint, by, speed)
    moved = motion.joint_position - POSE
    others = np.delete(moved, joint - 1, axis=1)
    assert not others.any()
    np.testing.assert_allclose(moved[[0, -1], joint - 1], [0, by], atol=1e-12)
    assert np.abs(motion.joint_velocity).max() <= 1.05 * speed
    assert np.abs(motion.joint_velocity[[0, -1]]).max() == pytest.approx(0, abs=1e-9)
    assert np.abs(motion.joint_acceleration).max() <= 2 * speed


def test_swing_is_gentle_and_comes_back() -> None:
    motion = swing(RIG, POSE, 2, 0.05)
    moved = motion.joint_position[:, 1] - POSE[1]
    assert (moved.min(), moved.max()) == (pytest.approx(-0.05, rel=0.01), pytest.approx(0.05, rel=0.01))
    assert np.abs(motion.joint_acceleration).max() == pytest.approx(GENTLE_ACCELERATION, rel=0.05)
    assert motion.cycles == SWINGS


def test_no_such_joint() -> None:
    with pytest.raises(BadInput, match="1 to 3 expected, 4 found"):
        jog(RIG, POSE, 4, 0.05)


def test_limit_is_named_and_the_way_back_from_beyond_it_is_free() -> None:
    rig = Rig(
        name="axis",
        mechanism="axes",
        axes=(Axis(),),
        drives=(Drive(node_id=1),),
        limits=Limits(joint_min=-0.2, joint_max=0.2),
        rate=100.0,
    )
    with pytest.raises(BadInput, match=r"limits\.joint_min or joint_max"):
        within_limits(jog(rig, np.array([0.1]), 1, 0.15), rig)
    with pytest.raises(BadInput, match="joint 1 angle"):
        within_limits(jog(rig, np.array([0.25]), 1, 0.01), rig)
    back = within_limits(jog(rig, np.array([0.25]), 1, -0.1), rig)
    assert back.joint_position[-1] == pytest.approx(0.15)
