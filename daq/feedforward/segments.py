"""Segments of a run: what is streamed one after the other, with the torque offsets."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from daq.feedforward.source import PlannedTorque
from daq.feedforward.watch import probe_signal
from recordings.interpolation import interpolate_columns
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory, approach

FADE_TIME = 0.5
"""Duration in which the offset rises from 0 at rest, and falls to 0 at the end [s]."""


@dataclass(frozen=True, eq=False)
class Segment:
    """Targets that are streamed one per cycle."""

    phase: str
    path: Floats
    """(m, dof) joint targets [rad]."""
    torque: Floats | None = None
    """(m, dof) torque offsets [N m]; None where the run has no feed-forward."""
    trajectory: Trajectory | None = None
    """The trajectory whose targets these are."""
    is_probe: bool = False
    """Whether the offsets are the test signal, to which the drives must answer."""


def segments(rig: Rig, start: Floats, trajectory: Trajectory, torque: PlannedTorque | None) -> Iterator[Segment]:
    """Segments from the position `start` (dof,) [rad] to the end of the trajectory."""
    goal = trajectory.joint_position[0]
    path = approach(start, goal, rig.limits, rig.rate)
    if torque is None:
        yield Segment("approach", path)
        yield Segment("stream", trajectory.joint_position, trajectory=trajectory)
        return
    signal = probe_signal(rig)
    yield Segment("probe", _hold(start, len(signal)), signal, is_probe=True)
    if torque.approach is None:
        yield Segment("approach", path, np.zeros_like(path))
        yield _fade(rig, "fade in", goal, torque.stream[0], rising=True)
    else:
        # The brakes may have let the robot sink a little since the plan was made.
        share, given = (np.linspace(0, 1, len(rows)) for rows in (path, torque.approach))
        along = interpolate_columns(share, given, torque.approach)  # at the same shares of the way
        yield _fade(rig, "fade in", start, along[0], rising=True)
        yield Segment("approach", path, between(along))
    yield Segment("stream", trajectory.joint_position, between(torque.stream), trajectory)
    yield _fade(rig, "fade out", trajectory.joint_position[-1], torque.stream[-1], rising=False)


def lead_in(rig: Rig) -> float:
    """Time that the segments before the approach take [s]."""
    return len(probe_signal(rig)) / rig.rate + FADE_TIME


def between(torque: Floats) -> Floats:
    """Torque while the drive moves from the previous target to each target: the offset is constant for a cycle, and
    the target is reached at its end."""
    before = np.concatenate([torque[:1], torque[:-1]])
    return (before + torque) / 2


def _fade(rig: Rig, phase: str, position: Floats, torque: Floats, *, rising: bool) -> Segment:
    count = max(2, round(FADE_TIME * rig.rate))
    u = np.arange(1, count + 1) / count
    share = u**2 * (3 - 2 * u)
    return Segment(phase, _hold(position, count), np.outer(share if rising else 1 - share, torque))


def _hold(position: Floats, count: int) -> Floats:
    return np.tile(position, (count, 1))
