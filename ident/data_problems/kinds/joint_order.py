"""Joints in another order in the positions than in the torques."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import prepare
from ident.data_problems.arrangement import MAX_OTHER, Arrangement, Arrangements
from ident.data_problems.facts import Facts
from ident.data_problems.remedies import mapping
from recordings.data_problems import DataProblem, joint_list
from recordings.errors import BadInput
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
    of_positions = _error_of_positions(facts, best)
    wrong = _positions_are_wrong(recording, best.order) if commanded else of_positions <= other / MAX_OTHER
    names = ("position", "velocity") if wrong else ("drive",)
    what = "positions" if wrong else "torques"
    # Where the mechanism looks the same with its joints exchanged, the torque does not tell which of both it is.
    open_ = not commanded and MAX_OTHER * other <= of_positions <= other / MAX_OTHER
    other = min(of_positions, other) if wrong else other
    doubt = " Without commands it may be the torques instead: then map those." if open_ else ""
    return DataProblem(
        kind="joint-order",
        joints=tuple(joints),
        blocks=True,
        why=f"The {what} of {joint_list(joints)} are in another order: as they are, {present:.0%} of the torque is "
        f"left unexplained, exchanged {other:.0%}.{doubt}",
        remedy=mapping(recording, names, best),
    )


def _error_of_positions(facts: Facts, best: Arrangement) -> float:
    """Error with the positions in the order of the torques, as a share of the torque."""
    order = np.argsort(best.order)
    try:
        prepared = [
            prepare(replace(each.recording, position=each.recording.position[:, order]), each.method, each.cutoff)
            for each in facts.recordings
        ]
    except BadInput:  # the mechanism cannot be assembled so
        return np.inf
    return Arrangements(prepared).present


def _positions_are_wrong(recording: Recording, order: tuple[int, ...]) -> bool:
    """Whether the command has the order of the torques and not of the positions."""
    command = recording.command
    exchanged = recording.position[:, np.argsort(order)]
    return bool(np.nanmean((command - exchanged) ** 2) < np.nanmean((command - recording.position) ** 2))
