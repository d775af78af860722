"""Compiled dynamics of rigid arms: a delta robot's, those of independent axes, or a tree of links."""

import math
from typing import Any

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.delta_motion import ball_torques, delta_motion, load_torques
from ident.dynamics.link_kernels import link_dynamics
from recordings.recording import Floats
from trajectories.closed_chain import dot

_TINY = 1e-9
"""Added to every inertia [kg m^2] so that none is zero."""


def _motion(constants: Floats, q: Floats, v: Floats, a: Floats) -> Any:
    lengths = (constants[0], constants[1], constants[2], constants[3])
    cosines, sines = (constants[7], constants[8], constants[9]), (constants[10], constants[11], constants[12])
    return delta_motion(lengths, cosines, sines, q, v, a)


def _delta_dynamics(constants: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats) -> None:
    """Torque (3,) and inertia (3, 3) of a delta's arms, Eq. (26), with uniform rods; NaN where it does not close."""
    T_g, m_d = constants[5], constants[6]
    mass, sixth = constants[4] + m_d, m_d / 6
    own = (
        T_g * math.cos(q[0]) + constants[13] * a[0],
        T_g * math.cos(q[1]) + constants[14] * a[1],
        T_g * math.cos(q[2]) + constants[15] * a[2],
    )
    _, J, tangents, lift, lifts = _motion(constants, q, v, a)
    loaded = load_torques(own, mass, m_d, J, tangents, lift, lifts)
    for i in range(3):
        torque[i] = loaded[i]
        for j in range(i + 1):
            coupled = 0.0
            for d in range(3):
                coupled += mass * J[i][d] * J[j][d]
                coupled += sixth * (tangents[i][d] * J[j][d] + J[i][d] * tangents[j][d])
            inertia[i, j] = inertia[j, i] = coupled
        inertia[i, i] += constants[13 + i] + m_d * constants[0] ** 2 / 3 + _TINY


def _axes_dynamics(constants: Floats, q: Floats, a: Floats, torque: Floats, inertia: Floats) -> None:
    dof = len(q)
    inertia[:] = 0.0
    for i in range(dof):
        weight = (
            constants[dof + i] * math.cos(q[i]) + constants[2 * dof + i] * math.sin(q[i]) + constants[3 * dof + i]
        )
        torque[i] = constants[i] * a[i] + weight
        inertia[i, i] = constants[i] + _TINY


def arm_dynamics(
    kind: int, constants: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats
) -> None:
    """Torque (dof,) of the arms at one instant, and its derivative by the acceleration, the inertia (dof, dof).

    kind: 0 of axes, 1 of a delta robot, 2 of a tree of links.
    """
    if kind == 0:
        _axes_dynamics(constants, q, a, torque, inertia)
    elif kind == 1:
        _delta_dynamics(constants, q, v, a, torque, inertia)
    else:
        link_dynamics(constants, q, v, a, torque, inertia)


def solve(matrix: Floats, vector: Floats, count: int) -> None:
    """Replace `vector` by the solution; the positive definite `matrix` (count, count) is overwritten."""
    for i in range(count):
        for j in range(i + 1, count):
            factor = matrix[j, i] / matrix[i, i]
            vector[j] -= factor * vector[i]
            for m in range(i, count):
                matrix[j, m] -= factor * matrix[i, m]
    for i in range(count - 1, -1, -1):
        for j in range(i + 1, count):
            vector[i] -= matrix[i, j] * vector[j]
        vector[i] /= matrix[i, i]


def known(q: Floats, v: Floats, a: Floats, k: int) -> bool:
    """Return whether the motion (n, dof) is known at instant `k`."""
    for i in range(q.shape[1]):
        if not (math.isfinite(q[k, i]) and math.isfinite(v[k, i]) and math.isfinite(a[k, i])):
            return False
    return True


@compiled
def dynamics_along(kind: int, constants: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Torque (n, dof) of the arms if they follow the motors, and the diagonal (n, dof) of their inertia matrix."""
    n, dof = q.shape
    torques, inertias = np.full((n, dof), np.nan), np.full((n, dof), np.nan)
    torque, inertia = np.zeros(dof), np.zeros((dof, dof))
    for k in range(n):
        arm_dynamics(kind, constants, q[k], v[k], a[k], torque, inertia)
        for i in range(dof):
            torques[k, i], inertias[k, i] = torque[i], inertia[i, i]
    return torques, inertias


@compiled
def platform_along(constants: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Velocity (n, 3) of a delta's platform, its Jacobian (n, 3, 3), torques (n, 3) of a mass and of rods of 1 kg."""
    n, nothing = len(q), (0.0, 0.0, 0.0)
    velocity, jacobian = np.empty((n, 3)), np.empty((n, 3, 3))
    torque_per_mass, torque_of_rods = np.empty((n, 3)), np.empty((n, 3))
    for k in range(n):
        P_dot, J, tangents, lift, lifts = _motion(constants, q[k], v[k], a[k])
        of_rods = load_torques(nothing, 1.0, 1.0, J, tangents, lift, lifts)
        for d in range(3):
            velocity[k, d], torque_per_mass[k, d], torque_of_rods[k, d] = P_dot[d], dot(J[d], lift), of_rods[d]
            for i in range(3):
                jacobian[k, d, i] = J[i][d]
    return velocity, jacobian, torque_per_mass, torque_of_rods


@compiled
def balls_along(constants: Floats, q: Floats, v: Floats) -> Floats:
    """Torques (2, n, 3) of unit dry and of unit viscous friction in the balls of a delta's rods."""
    torques = np.empty((2, len(q), 3))
    lengths = (constants[0], constants[1], constants[2])
    cosines, sines = (constants[7], constants[8], constants[9]), (constants[10], constants[11], constants[12])
    for k in range(len(q)):
        dry, viscous = ball_torques(lengths, cosines, sines, q[k], v[k])
        for i in range(3):
            torques[0, k, i], torques[1, k, i] = dry[i], viscous[i]
    return torques
