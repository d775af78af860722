"""Rods (forearms) of uniform mass, which the base model lumps at platform and arms."""

import numpy as np

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


def horizontal_gravity_torque(geometry: Geometry, motion: Motion) -> Floats:
    """Torque (n, 2, 3) [N m] of such rods per unit of gravity [m/s^2] along x and along y.

    A rod's centre moves half as much as its elbow and half as much as the platform.
    """
    outwards = np.stack([np.cos(geometry.phi), np.sin(geometry.phi)])
    elbows = -geometry.L1 * np.sin(motion.position)[:, None] * outwards  # velocity per joint velocity
    torque: Floats = -(elbows + 3 * platform(geometry, motion).jacobian[:, :2]) / 2
    return torque
