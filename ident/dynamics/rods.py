"""Rods (forearms) of uniform mass, which the base model lumps at platform and arms."""

from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

GRAVITY = -float(kinematics.GRAVITY[2])
"""[m/s^2], downwards."""


def torque(geometry: Geometry, motion: Motion) -> Floats:
    """Torque (n, 3) [N m] that moves and lifts one uniform rod of 1 kg in each limb.

    A rod whose ends accelerate with a_1 (elbow) and a_2 (platform) resists with m (2 a_1 + a_2) / 6 at the elbow and
    m (a_1 + 2 a_2) / 6 at the platform; the same for its weight.
    """
    return platform(geometry, motion).torque_of_rods
