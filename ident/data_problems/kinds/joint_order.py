"""Joints in another order in the positions than in the torques."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import prepare
from ident.data_problems.arrangement import MAX_OTHER, Arrangement, error_of
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
    exchanged = [_exchanged(each.recording, best) for each in facts.recordings]
    of_positions = error_of(
        prepare(other_order, each.method, each.cutoff)
        for other_order, each in zip(exchanged, facts.recordings, strict=True)
    )
    wrong = _from_command(exchanged[0]) < _from_command(recording) if commanded else of_positions <= other / MAX_OTHER
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


def _exchanged(recording: Recording, best: Arrangement) -> Recording:
    """The `recording` with the positions in the order of the torques."""
    return replace(recording, position=recording.position[:, np.argsort(best.order)])


def _from_command(recording: Recording) -> float:
    """Mean square of what the positions differ by from the command."""
    return float(np.nanmean((recording.command - recording.position) ** 2))
