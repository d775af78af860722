"""What the kinds of data problems look at: the motion, and the signal that tells the torque."""

import numpy as np

from recordings.recording import Bools, Floats, Recording

MIN_TRAVEL = 1e-3
"""A joint with less travel stands still [rad or m]."""
LEAST_SIGNAL = 1e-100
"""Differences of torques or voltages below this are none: their squares must not vanish."""
MAX_SPAN = np.pi
"""No arm of a delta robot turns by more than half a turn [rad]."""
SLOWEST, FASTEST = 5.0, 100_000.0
"""Samples per second [Hz] with which motions are recorded."""
MOVING = 0.05
"""A joint moves where it is faster than this share of its 95th percentile."""


def drive_signal(recording: Recording) -> tuple[str, Floats]:
    """Name of the signal (n, dof) that tells the torque, and its values: voltage [V], or effort [N m or N]."""
    if recording.effort is not None and not np.isfinite(recording.voltage).any():
        return "effort", recording.effort
    return "voltage", recording.voltage


def of_motion(recording: Recording) -> Bools:
    """(n,) rows of the repeated motion; all where no repetitions are marked."""
    repeated: Bools = recording.repeat >= 0
    return repeated if repeated.any() else np.ones(len(recording.time), bool)


def travel(column: Floats) -> float:
    """Distance between the ends of the motion of a joint, from its positions (n,); 0 without any."""
    known = column[np.isfinite(column)]
    return float(np.ptp(known)) if len(known) else 0.0


def moving(recording: Recording, joint: int) -> Bools:
    """(n,) rows in which the `joint`, from 0, moves."""
    speed = np.abs(np.gradient(recording.position[:, joint], recording.time))
    known = speed[np.isfinite(speed)]
    limit = MOVING * float(np.quantile(known, 0.95)) if len(known) else np.inf
    return of_motion(recording) & (np.nan_to_num(speed) > limit)
