"""Conversion of motions to trajectories, which are checked against limits, and to inputs of regressors."""

import numpy as np

from ident.basics.filters import mean_sign
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory, kinematics


def trajectory(
    name: str, rig: Rig, rate: float, position: Floats, velocity: Floats, acceleration: Floats
) -> Trajectory:
    """Return the motion of the joints (n, dof) [rad or m, /s, /s^2] at `rate` [Hz] as a repeated trajectory.

    Raises:
        Unreachable: the mechanism does not close.
    """
    delta = rig.mechanism == "delta"
    return Trajectory(
        name=name,
        description="",
        digest="",
        rate=rate,
        period=len(position) / rate,
        cycles=1,
        platform=kinematics.forward(rig.geometry, position) if delta else np.full((len(position), 3), np.nan),
        joint_position=position,
        joint_velocity=velocity,
        joint_acceleration=acceleration,
        repeat=np.zeros(len(position), np.int64),
    )


def repeated_motion(trajectory: Trajectory) -> Motion:
    """Return the repeated part of `trajectory`."""
    rows = trajectory.repeat >= 0
    position, velocity, acceleration, direction = (
        signal[rows]
        for signal in (
            trajectory.joint_position,
            trajectory.joint_velocity,
            trajectory.joint_acceleration,
            np.nan_to_num(mean_sign(trajectory.joint_velocity)),
        )
    )
    return Motion(position, velocity, acceleration, direction)
