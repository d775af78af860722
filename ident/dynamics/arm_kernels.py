"""Compiled: motion and loads of a delta robot's arms, and small systems of equations."""

from typing import Any

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.delta_motion import ball_torques, delta_motion, load_torques
from recordings.recording import Floats
from trajectories.closed_chain import dot


def _motion(constants: Floats, q: Floats, v: Floats, a: Floats) -> Any:
    lengths = (constants[0], constants[1], constants[2], constants[3])
    cosines, sines = (constants[4], constants[5], constants[6]), (constants[7], constants[8], constants[9])
    return delta_motion(lengths, cosines, sines, q, v, a)


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
    cosines, sines = (constants[4], constants[5], constants[6]), (constants[7], constants[8], constants[9])
    for k in range(len(q)):
        dry, viscous = ball_torques(lengths, cosines, sines, q[k], v[k])
        for i in range(3):
            torques[0, k, i], torques[1, k, i] = dry[i], viscous[i]
    return torques
