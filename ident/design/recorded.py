"""Recordings on which a design is based: rig, motion and fitted parameters."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident.data.compatibility import check_same_rig
from ident.data.excerpts import excerpts
from ident.data.prepared_recording import prepare
from ident.data.samples import holds_torque
from ident.design.model import mandatory_effects, with_effects
from ident.design.motions import trajectory
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import Rig
from trajectories import Trajectory


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """Motion and parameters of a recording."""

    rig: Rig
    trajectory: Trajectory
    """Measured motion without gaps."""
    parameters: Floats
    """(k,) parameters of the mechanism with its mandatory effects, fitted by least squares."""
    torque_measured: bool
    """True if the recording contains the torque itself, not a voltage."""


def read_recorded_motions(paths: Sequence[Path]) -> list[RecordedMotion]:
    """Read the recordings in the files `paths`, or their beginnings if they are long.

    Raises:
        BadInput: a recording cannot be read or prepared, or they are not of the same rig.
    """
    recordings = [excerpts(read(path))[0].recording for path in paths]
    if recordings:
        check_same_rig(recordings, own_gains=False)
    return [_recorded_motion(recording) for recording in recordings]


def _recorded_motion(recording: Recording) -> RecordedMotion:
    prepared = prepare(recording, "parallel", None)
    rig, motion = recording.rig, prepared.as_recorded.motion
    regressor = prepared.condition(with_effects(rig, mandatory_effects(rig)).regressor(motion))
    torque = prepared.torque
    usable = prepared.usable & np.isfinite(regressor).all(axis=2)
    parameters = np.asarray(np.linalg.lstsq(regressor[usable], torque[usable], rcond=None)[0], np.float64)
    signals = (motion.position, motion.velocity, motion.acceleration)
    complete = np.isfinite(signals).all(axis=(0, 2))
    position, velocity, acceleration = (signal[complete] for signal in signals)
    measured = trajectory(recording.path.name, rig, prepared.samples.rate, position, velocity, acceleration)
    return RecordedMotion(rig, measured, parameters, holds_torque(recording))
