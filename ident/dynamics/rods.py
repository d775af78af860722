"""Rods (forearms) of uniform mass, which the base model lumps at platform and arms."""

import numpy as np

from ident.dynamics.motion import Motion, cached_for_motion
from ident.dynamics.platform import platform
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

GRAVITY = -float(kinematics.GRAVITY[2])
"""[m/s^2], downwards."""


@cached_for_motion
def torque(geometry: Geometry, motion: Motion) -> Floats:
    """Torque (n, 3) [N m] that moves and lifts one uniform rod of 1 kg in each limb; cached for each `motion`.

    A rod whose ends accelerate with a_1 (elbow) and a_2 (platform) resists with m (2 a_1 + a_2) / 6 at the elbow and
    m (a_1 + 2 a_2) / 6 at the platform; the same for its weight.
    """
    platform_motion = platform(geometry, motion)
    a_2 = platform_motion.lift[:, None]
    tangent, acceleration = _elbows(geometry, motion)
    a_1 = acceleration - kinematics.GRAVITY
    at_elbow = np.einsum("njx,njx->nj", tangent, 2 * a_1 + a_2) / 6
    at_platform = ((a_1 + 2 * a_2) / 6).sum(axis=1)
    torque: Floats = at_elbow + np.einsum("nxj,nx->nj", platform_motion.jacobian, at_platform)
    return torque


def horizontal_gravity_torque(geometry: Geometry, motion: Motion) -> Floats:
    """Torque (n, 2, 3) [N m] of such rods per unit of gravity [m/s^2] along x and along y.

    A rod's centre moves half as much as its elbow and half as much as the platform.
    """
    tangent, _ = _elbows(geometry, motion)
    torque: Floats = -(tangent[:, :, :2].swapaxes(1, 2) + 3 * platform(geometry, motion).jacobian[:, :2]) / 2
    return torque


def _elbows(geometry: Geometry, motion: Motion) -> tuple[Floats, Floats]:
    """Elbow of each limb: velocity per joint velocity (n, 3, 3), and acceleration (n, 3, 3)."""
    out = np.stack([np.cos(geometry.phi), np.sin(geometry.phi), np.zeros(3)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    sine, cosine = (f(motion.position)[:, :, None] for f in (np.sin, np.cos))
    tangent = geometry.L1 * (cosine * up - sine * out)
    inward = -geometry.L1 * (cosine * out + sine * up)
    acceleration = tangent * motion.acceleration[:, :, None] + inward * motion.velocity[:, :, None] ** 2
    return tangent, acceleration
