"""Inverse dynamics of the delta robot with uniform rods, exact, by virtual work.

Independent of the plant and of the models in `ident`: the rods are rigid bodies with a centre of mass and a
transverse inertia, and all derivatives of the motion are finite differences of positions.
"""

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.config import Links
from recordings.rig import Geometry
from trajectories import kinematics

Floats = NDArray[np.float64]

LEVEL = (0.0, 0.0, -9.81)
_H_TIME = 1e-3
_H_ANGLE = 1e-5


def exact_torque(
    geometry: Geometry,
    links: Links,
    theta: Floats,
    rate: Floats,
    acceleration: Floats,
    gravity: tuple[float, float, float] = LEVEL,
) -> Floats:
    """Torque (n, 3) [N m] of the motors, without friction, for the motion (n, 3) in rad, rad/s, rad/s^2.

    Every mass point and every rod direction contributes inertia times acceleration, minus weight, times its
    displacement per unit of joint angle (d'Alembert).
    """
    weights, now = _weights(geometry, links), _points(geometry, links, theta)
    bend = 0.5 * _H_TIME**2 * acceleration
    before, after = (_points(geometry, links, theta + sign * _H_TIME * rate + bend) for sign in (-1, 1))
    force = weights[:, None] * (after - 2 * now + before) / _H_TIME**2
    masses = slice(0, 7)
    force[:, masses] -= weights[masses, None] * np.array(gravity)
    torque = (links.motor_inertia + links.arm_inertia) * acceleration
    for i in range(3):
        step = _H_ANGLE * np.eye(3)[i]
        ahead, behind = _points(geometry, links, theta + step), _points(geometry, links, theta - step)
        displacement = (ahead - behind) / (2 * _H_ANGLE)
        torque[:, i] += np.einsum("nkj,nkj->n", force, displacement)
    return torque


def _weights(geometry: Geometry, links: Links) -> Floats:
    """Mass of platform, arms and rods; transverse inertia of the rods."""
    inertia = links.rod_mass * geometry.L2**2 / 12
    platform = links.platform_mass + links.payload
    return np.array([platform] + [links.arm_mass] * 3 + [links.rod_mass] * 3 + [inertia] * 3)


def _points(geometry: Geometry, links: Links, theta: Floats) -> Floats:
    """(n, 10, 3): centres of platform, arms and rods, then the rods' directions."""
    P = kinematics.forward(geometry, theta)
    outwards = np.array([[np.cos(phi), np.sin(phi), 0.0] for phi in geometry.phi])
    along = np.cos(theta)[:, :, None] * outwards + np.sin(theta)[:, :, None] * np.array([0.0, 0.0, 1.0])
    elbow = geometry.R * outwards + geometry.L1 * along
    tip = P[:, None, :] + geometry.r * outwards
    arm = geometry.R * outwards + links.arm_com * along
    return np.concatenate([P[:, None, :], arm, (elbow + tip) / 2, (tip - elbow) / geometry.L2], axis=1)
