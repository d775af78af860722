"""Torque that is mostly empty, or constant while the joint moves."""

import numpy as np

from recordings.data_problems import DataProblem
from recordings.data_problems.signals import LEAST_SIGNAL, MIN_TRAVEL, drive_signal, of_motion, travel
from recordings.recording import Floats, Recording

MIN_USABLE = 0.2
"""Smallest share of the rows of the motion with a torque between two others: what is measured only now and then
cannot be filtered."""


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if a joint that moves has hardly any torque, voltage or current."""
    rows = of_motion(recording)
    name, signal = drive_signal(recording)
    moves = [joint for joint, column in enumerate(recording.position[rows].T, 1) if travel(column) > MIN_TRAVEL]
    faults = {joint: fault for joint in moves if (fault := _fault(signal[rows, joint - 1]))}
    if not faults:
        return None
    text = "; ".join(f"{name} {joint} {fault}" for joint, fault in faults.items())
    return DataProblem(
        kind="missing-torque",
        joints=tuple(faults),
        blocks=True,
        why=f"In motion, {text}: that cannot be the torque that moves a joint.",
        remedy="Record the torque, the current or the voltage of every sample of every joint, and check the mapping.",
    )


def _fault(signal: Floats) -> str | None:
    known = np.isfinite(signal)
    usable = known[1:-1] & known[:-2] & known[2:]
    if usable.sum() < MIN_USABLE * len(signal):
        return f"is empty in {1 - known.mean():.0%} of the rows"
    return f"is {signal[known][0]:g} throughout" if np.ptp(signal[known]) < LEAST_SIGNAL else None
