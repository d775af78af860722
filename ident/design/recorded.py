"""What a recording that exists tells about the next motion: its rig, its motion, the load."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident.course import prepare
from ident.design.motions import trajectory
from ident.design.rivals import always_true
from ident.design.with_effects import with_effects
from ident.diagnose.excerpts import excerpts
from recordings.reader import read
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory


@dataclass(frozen=True, eq=False)
class Recorded:
    """A recording, as a design sees it."""

    rig: Rig
    trajectory: Trajectory
    """The measured motion without gaps."""
    known: Floats
    """(k,) parameters of the mechanism with what is always true of it, fitted by least squares."""


def recorded(path: Path) -> Recorded:
    """The recording in the file `path`, or its beginning if it is long.

    Raises:
        BadInput: it cannot be read or prepared.
    """
    recording = excerpts(read(path))[0].recording
    course = prepare(recording, "parallel", None)
    rig, motion = recording.rig, course.path.motion
    regressor = course.condition(with_effects(rig, always_true(rig)).regressor(motion))
    torque = course.dataset.torque
    usable = course.usable & np.isfinite(regressor).all(axis=2)
    known: Floats = np.linalg.lstsq(regressor[usable], torque[usable], rcond=None)[0]
    signals = (motion.position, motion.velocity, motion.acceleration)
    whole = np.isfinite(signals).all(axis=(0, 2))
    position, velocity, acceleration = (signal[whole] for signal in signals)
    made = trajectory(path.name, rig, course.samples.rate, position, velocity, acceleration)
    return Recorded(rig, made, known)
