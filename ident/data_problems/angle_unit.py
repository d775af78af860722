"""Angles in degrees where the mechanism of a delta robot tells that they cannot be radians."""

import numpy as np

from recordings.command_line import repeated
from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import MAX_SPAN
from recordings.recording import Recording
from trajectories import kinematics


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if an arm turns further than it can, and the mechanism closes if the angles are degrees."""
    position = recording.position[np.isfinite(recording.position).all(axis=1)]
    if recording.rig.mechanism != "delta" or not len(position) or (np.ptp(position, axis=0) < MAX_SPAN).all():
        return None
    try:
        kinematics.forward(recording.rig.geometry, np.radians(position))
    except kinematics.Unreachable:
        return None
    entries = [f"position_{joint}=position_{joint}:deg" for joint in range(1, recording.rig.dof + 1)]
    return DataProblem(
        kind="angle-unit",
        joints=(),
        blocks=True,
        why="An arm turns by more than half a turn; the mechanism closes if these angles are degrees.",
        remedy=healing_command(recording.path, repeated("--map", entries)),
    )
