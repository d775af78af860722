"""Positions that are the derivative or the integral of what their name says."""

import numpy as np

from recordings.data_problems import DataProblem, joint_list
from recordings.data_problems.signals import MAX_SPAN, of_motion
from recordings.recording import Floats, Recording

_NEAR, _FAR = 0.98, 0.5
"""Correlation above which two signals are the same, and below which they are not."""


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if a position is the derivative of its command, equals its velocity, or turns an arm of a
    delta robot further than it can, where its integral does not."""
    rows = of_motion(recording)
    joints = [joint for joint in range(1, recording.rig.dof + 1) if _is_velocity(recording, joint - 1, rows)]
    if not joints:
        return None
    return DataProblem(
        kind="derivative",
        joints=tuple(joints),
        blocks=True,
        why=f"The position of {joint_list(joints)} is a velocity: it is the derivative of the command, equals the "
        "velocity that was recorded, or would turn an arm by more than half a turn, which its integral does not.",
        remedy="Map the column that holds the position, as position_1=COLUMN:rad (daq import --map, in Python map), "
        "or record it.",
    )


def _is_velocity(recording: Recording, joint: int, rows: np.ndarray) -> bool:
    position, time = recording.position[rows, joint], recording.time[rows]
    command = recording.command[rows, joint]
    if _correlation(np.gradient(command, time), position) > _NEAR and abs(_correlation(command, position)) < _FAR:
        return True
    if recording.rig.mechanism == "delta" and _is_speed_of_arm(position, time):
        return True
    if recording.velocity is None:
        return False
    velocity = recording.velocity[rows, joint]
    slope = np.gradient(position, time)
    return _correlation(velocity, position) > _NEAR and abs(_correlation(velocity, slope)) < _FAR


def _is_speed_of_arm(position: Floats, time: Floats) -> bool:
    """Whether `position` (n,) goes further than an arm can, without a jump, and its integral over `time` does not."""
    known = np.isfinite(position)
    position, time = position[known], time[known]
    if len(position) < 2 or np.ptp(position) < MAX_SPAN or np.abs(np.diff(position)).max() > MAX_SPAN:
        return False
    return bool(np.ptp(np.cumsum(position[1:] * np.diff(time))) < MAX_SPAN)


def _correlation(x: Floats, y: Floats) -> float:
    """Correlation of two signals (n,) where both are known; 0 where one is constant."""
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < 10 or not np.ptp(x[known]) or not np.ptp(y[known]):
        return 0.0
    return float(np.corrcoef(x[known], y[known])[0, 1])
