"""Friction of the balls at both ends of the rods."""

import numpy as np

from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics


def ball_torques(geometry: Geometry, q: Floats, v: Floats) -> Floats:
    """(2, n, 3) torque of unit dry [N m] and of unit viscous [N m s/rad] friction in each ball; q, v: (n, 3).

    The power at the joints is that of the balls. Arms and rods turn with the cross product of a unit vector along
    them and its derivative.
    """
    P, _, _, J = kinematics.platform_motion(geometry, q, v, np.zeros_like(v))
    torques = np.zeros((2, *q.shape))
    for phi, own, cos, sin in zip(geometry.phi, np.eye(3)[:, :, None], np.cos(q).T, np.sin(q).T, strict=True):
        out, up = np.array([np.cos(phi), np.sin(phi), 0.0]), np.array([0.0, 0.0, 1.0])
        arm, turned = np.outer(cos, out) + np.outer(sin, up), np.outer(cos, up) - np.outer(sin, out)
        rod = (P - (geometry.R - geometry.r) * out - geometry.L1 * arm) / geometry.L2
        moved = np.moveaxis(J, 2, 1) - own * geometry.L1 * turned[:, None, :]
        of_rod = np.cross(rod[:, None, :], moved) / geometry.L2
        for by_rate in (of_rod, of_rod - own * np.cross(arm, turned)[:, None, :]):
            spin = np.einsum("njd,nj->nd", by_rate, v)
            unit = spin / (np.linalg.norm(spin, axis=1, keepdims=True) + 1e-12)
            torques += np.stack([np.einsum("njd,nd->nj", by_rate, each) for each in (unit, spin)])
    return torques
