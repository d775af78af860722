"""Following error of a recorded motion: of each joint, and of a delta robot's platform."""

from dataclasses import dataclass

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from trajectories import kinematics


@dataclass(frozen=True, eq=False)
class Following:
    """How well one run followed its motion."""

    rms: Floats
    """Following error per joint (dof,) [rad or m]."""
    worst: Floats
    """(dof,)"""
    platform_rms: float | None = None
    """Distance of the platform from its path [m]; None for a mechanism without platform."""
    platform_worst: float | None = None

    @property
    def overall(self) -> float:
        """RMS over all joints [rad or m]."""
        return float(np.sqrt(np.mean(self.rms**2)))


def following(recording: Recording) -> Following:
    """Following error of the repetitions of `recording`, without approach and ramps.

    Raises:
        BadInput: it has no target with an answer there.
    """
    error = recording.following_error
    known = (recording.repeat >= 0) & np.isfinite(error).all(axis=1)
    if not known.any():
        raise BadInput(
            f"{recording.path.name}: targets and positions of a repeated motion expected, none found; record it anew"
        )
    error, position = error[known], recording.position[known]
    rms, worst = np.sqrt((error**2).mean(axis=0)), np.abs(error).max(axis=0)
    if recording.rig.mechanism != "delta":
        return Following(rms, worst)
    geometry = recording.rig.geometry
    away = kinematics.forward(geometry, position + error) - kinematics.forward(geometry, position)
    distance = np.sqrt((away**2).sum(axis=1))
    return Following(rms, worst, float(np.sqrt((distance**2).mean())), float(distance.max()))
