import numpy as np
import pytest

from daq.feedforward.segments import lead_in, segments
from daq.feedforward.source import PlannedTorque
from recordings.rig import simulated_rig
from trajectories import approach, load

RIG = simulated_rig().at_rate(100.0)
TRAJECTORY = load("fig5b", RIG, cycles=1)
START = np.array([0.3, 0.3, 0.3])
PATH = approach(START, TRAJECTORY.joint_position[0], RIG.limits, RIG.rate)
TORQUE = np.outer(np.linspace(5, 9, len(TRAJECTORY.time)), [1, 1, 1])
WAY = np.outer(np.linspace(7, 5, len(PATH)), [1, 1, 1])


@pytest.mark.parametrize("along_the_approach", [None, WAY])
def test_offset_begins_and_ends_at_zero_without_a_jump(along_the_approach: np.ndarray | None) -> None:  # type: ignore[type-arg]
    parts = list(segments(RIG, START, TRAJECTORY, PlannedTorque(along_the_approach, TORQUE, "")))
    assert parts[0].is_probe
    assert not any(part.is_probe for part in parts[1:])
    offsets = np.concatenate([part.torque for part in parts[1:] if part.torque is not None])
    np.testing.assert_allclose(offsets[[0, -1]], 0, atol=0.01)
    assert np.abs(np.diff(offsets, axis=0)).max() < 0.3
    path = np.concatenate([part.path for part in parts])
    np.testing.assert_array_equal(path[0], START)
    assert np.abs(np.diff(path, axis=0)).max() * RIG.rate < RIG.limits.speed
    before = sum(len(part.path) for part in parts[: [part.phase for part in parts].index("stream")]) - len(PATH)
    assert before / RIG.rate == pytest.approx(lead_in(RIG))


def test_sunk_robot_gets_the_torque_of_the_whole_approach() -> None:
    sunk = START - 0.1
    parts = {part.phase: part for part in segments(RIG, sunk, TRAJECTORY, PlannedTorque(WAY, TORQUE, ""))}
    offsets = parts["approach"].torque
    assert offsets is not None
    assert len(offsets) == len(parts["approach"].path) != len(WAY)
    np.testing.assert_allclose(offsets[[0, -1], 0], [7.0, 5.0], atol=0.1)
