"""What a recording that exists tells about the next motion: its rig, its motion, the load."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident.data.compatibility import check_same_rig
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import prepare
from ident.data.samples import holds_torque
from ident.design.discrimination import mandatory_effects
from ident.design.motions import trajectory
from ident.design.with_effects import with_effects
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import Rig
from trajectories import Trajectory


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A recording, as a design sees it."""

    rig: Rig
    trajectory: Trajectory
    """The measured motion without gaps."""
    parameters: Floats
    """(k,) parameters of the mechanism with what is always true of it, fitted by least squares."""
    torque_measured: bool
    """Whether it holds the torque itself, and no voltage."""


def read_recorded_motions(paths: Sequence[Path]) -> list[RecordedMotion]:
    """The recordings in the files `paths`, or their beginnings if they are long.

    Raises:
        BadInput: one cannot be read or prepared, or they are not of the same rig.
    """
    recordings = [excerpts(read(path))[0].recording for path in paths]
    if recordings:
        check_same_rig(recordings)
    return [_seen(recording) for recording in recordings]


def _seen(recording: Recording) -> RecordedMotion:
    course = prepare(recording, "parallel", None)
    rig, motion = recording.rig, course.as_recorded.motion
    regressor = course.condition(with_effects(rig, mandatory_effects(rig)).regressor(motion))
    torque = course.dataset.torque
    usable = course.usable & np.isfinite(regressor).all(axis=2)
    known = np.asarray(np.linalg.lstsq(regressor[usable], torque[usable], rcond=None)[0], np.float64)
    signals = (motion.position, motion.velocity, motion.acceleration)
    whole = np.isfinite(signals).all(axis=(0, 2))
    position, velocity, acceleration = (signal[whole] for signal in signals)
    made = trajectory(recording.path.name, rig, course.samples.rate, position, velocity, acceleration)
    return RecordedMotion(rig, made, known, holds_torque(recording))
