"""Joints in another order in the positions than in the torques."""

import numpy as np

from ident.data_problems.facts import Facts
from ident.data_problems.remedies import mapping
from recordings.data_problems import DataProblem, joint_list
from recordings.recording import Recording


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if another order of the torques explains the motion far better."""
    found = facts.arrangements.best
    if found is None or not found[0].moved:
        return None
    best, present, other = found
    joints = [joint + 1 for joint in best.moved]
    recording = facts.recordings[0].recording
    commanded = np.isfinite(recording.command).any()
    names = ("position", "velocity") if not commanded or _positions_are_wrong(recording, best.order) else ("drive",)
    what = "positions" if names[0] == "position" else "torques"
    doubt = "" if commanded else " Without commands it may be the torques instead: then map those."
    return DataProblem(
        kind="joint-order",
        joints=tuple(joints),
        blocks=True,
        why=f"The {what} of {joint_list(joints)} are in another order: as they are, {present:.0%} of the torque is "
        f"left unexplained, exchanged {other:.0%}.{doubt}",
        remedy=mapping(recording, names, best),
    )


def _positions_are_wrong(recording: Recording, order: tuple[int, ...]) -> bool:
    """Whether the command has the order of the torques and not of the positions."""
    command = recording.command
    exchanged = recording.position[:, np.argsort(order)]
    return bool(np.nanmean((command - exchanged) ** 2) < np.nanmean((command - recording.position) ** 2))
