"""Angles that jump by a whole turn: the encoder, or the program that recorded, began to count anew."""

import numpy as np

from recordings.data_problems import DataProblem, healing_command, joint_list
from recordings.interpolation import MAX_GAP
from recordings.recording import Bools, Floats, Recording

_TURN = 2 * np.pi
_NEAR = 0.1
"""A jump is a whole turn if it differs by less than this share."""


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if a revolute joint jumps by whole turns."""
    kinds, neighbours = zip(recording.position.T, recording.rig.joint_types, strict=True), _neighbours(recording.time)
    joints = [
        joint for joint, (column, kind) in enumerate(kinds, 1) if kind == "revolute" and _wraps(column, neighbours)
    ]
    if not joints:
        return None
    numbers = ",".join(map(str, joints))
    return DataProblem(
        kind="angle-wrap",
        joints=tuple(joints),
        blocks=True,
        why=f"The position of {joint_list(joints)} jumps by a whole turn and back: angles were kept within one turn.",
        remedy=healing_command(recording.path, ["--unwrap", numbers]),
    )


def _neighbours(time: Floats) -> Bools:
    """(n - 1,) whether each sample follows the one before it without a gap."""
    steps = np.diff(time)
    return steps <= MAX_GAP * np.median(steps)


def _wraps(angle: Floats, neighbours: Bools) -> bool:
    """Whether the steps of `angle` (n,) are small but for whole turns; across gaps a joint moves on."""
    steps = np.diff(angle)
    steps = steps[np.isfinite(steps) & neighbours]
    jumps = np.abs(steps) > _TURN / 2
    turns = np.abs(np.abs(steps[jumps]) - _TURN) < _NEAR * _TURN
    return bool(jumps.any() and turns.all() and np.abs(steps[~jumps]).max(initial=0.0) < _TURN / 4)
