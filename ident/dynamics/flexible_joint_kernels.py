"""Compiled kernels of `ident.dynamics.flexible_joints`.

All are in one file: numba recompiles a cached function when its own file changes, but not when the file of a function
changes that it calls.

The twist of a joint, `twist` or `x`, is the angle by which the motor is ahead of the arm; `twist_rate` or `w` is its
derivative.
"""

import math

import numpy as np

from ident.numba_cache import compiled
from recordings.recording import Bools, Floats

_TINY = 1e-9
"""Added to every inertia [kg m^2] so that none is zero."""
_SETTLING_STEPS = 50
"""Iterations to the initial static twist."""


def _delta_dynamics(  # noqa: C901 - compiled: nothing but numbers in small loops
    constants: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats, workspace: Floats
) -> None:
    """Torque (3,) and inertia (3, 3) of a delta's arms: (A3)-(A8), (15)-(16), (23), (26), with uniform rods.

    workspace: (26, 3), any content.
    """
    L1, L2, out, g = constants[0], constants[1], constants[2], constants[3]
    m_p, T_g, m_d = constants[4], constants[5], constants[6]
    elbow, tangent, rod, rod_rate, rows, J = (
        workspace[:3],
        workspace[3:6],
        workspace[6:9],
        workspace[9:12],
        workspace[12:15],
        workspace[15:18],
    )
    first, second, normal, P, P_dot, P_ddot = (
        workspace[18],
        workspace[19],
        workspace[20],
        workspace[21],
        workspace[22],
        workspace[23],
    )
    sines, cosines = workspace[24], workspace[25]
    for i in range(3):
        cos_phi, sin_phi = constants[7 + i], constants[10 + i]
        sine, cosine = math.sin(q[i]), math.cos(q[i])
        sines[i], cosines[i] = sine, cosine
        elbow[i, 0], elbow[i, 1], elbow[i, 2] = (
            (out + L1 * cosine) * cos_phi,
            (out + L1 * cosine) * sin_phi,
            L1 * sine,
        )
        tangent[i, 0], tangent[i, 1], tangent[i, 2] = -L1 * sine * cos_phi, -L1 * sine * sin_phi, L1 * cosine
    aa = bb = cc = 0.0
    for d in range(3):
        first[d], second[d] = elbow[1, d] - elbow[0, d], elbow[2, d] - elbow[0, d]
        aa += first[d] ** 2
        bb += second[d] ** 2
        cc += (first[d] - second[d]) ** 2
    _cross(first, second, normal)
    nn = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    height_squared = L2**2 - aa * bb * cc / (4 * nn)
    if not height_squared >= 0.0:  # no position closes the loop
        torque[:] = np.nan
        inertia[:] = np.nan
        return
    drop = math.copysign(math.sqrt(height_squared / nn), normal[2])
    for d in range(3):
        first[d] = aa * second[d] - bb * first[d]
    _cross(first, normal, second)
    for d in range(3):
        P[d] = elbow[0, d] + second[d] / (2 * nn) - drop * normal[d]
    for i in range(3):
        for d in range(3):
            rod[i, d] = P[d] - elbow[i, d]
    for i in range(3):  # rows of the transposed inverse, not yet divided by the determinant
        _cross(rod[(i + 1) % 3], rod[(i + 2) % 3], rows[i])
    determinant = rod[0, 0] * rows[0, 0] + rod[0, 1] * rows[0, 1] + rod[0, 2] * rows[0, 2]
    for i in range(3):
        leverage = rod[i, 0] * tangent[i, 0] + rod[i, 1] * tangent[i, 1] + rod[i, 2] * tangent[i, 2]
        for d in range(3):
            rows[i, d] /= determinant
            J[i, d] = rows[i, d] * leverage
    for d in range(3):
        P_dot[d] = J[0, d] * v[0] + J[1, d] * v[1] + J[2, d] * v[2]
        P_ddot[d] = J[0, d] * a[0] + J[1, d] * a[1] + J[2, d] * a[2]
    for i in range(3):
        sine, cosine = sines[i], cosines[i]
        tangent_derivative = (-L1 * cosine * constants[7 + i], -L1 * cosine * constants[10 + i], -L1 * sine)
        curvature = 0.0
        for d in range(3):
            rod_rate[i, d] = P_dot[d] - tangent[i, d] * v[i]
            curvature += (rod_rate[i, d] * tangent[i, d] + rod[i, d] * tangent_derivative[d] * v[i]) * v[
                i
            ] - rod_rate[i, d] * P_dot[d]
        for d in range(3):
            P_ddot[d] += rows[i, d] * curvature
    P_ddot[2] += g  # from here on minus gravity
    force = first
    for d in range(3):
        force[d] = (m_p + m_d) * P_ddot[d]
    for i in range(3):
        sine, cosine = sines[i], cosines[i]
        tangent_derivative = (-L1 * cosine * constants[7 + i], -L1 * cosine * constants[10 + i], -L1 * sine)
        torque[i] = T_g * cosine + constants[13 + i] * a[i]
        for d in range(3):
            elbow_acceleration = tangent[i, d] * a[i] + tangent_derivative[d] * v[i] ** 2 + (g if d == 2 else 0.0)
            torque[i] += m_d * tangent[i, d] * (2 * elbow_acceleration + P_ddot[d]) / 6
            force[d] += m_d * elbow_acceleration / 6
    for i in range(3):
        torque[i] += J[i, 0] * force[0] + J[i, 1] * force[1] + J[i, 2] * force[2]
        for j in range(3):
            inertia[i, j] = 0.0
            for d in range(3):
                inertia[i, j] += (m_p + m_d) * J[i, d] * J[j, d]
                inertia[i, j] += m_d * (tangent[i, d] * J[j, d] + J[i, d] * tangent[j, d]) / 6
        inertia[i, i] += constants[13 + i] + m_d * L1**2 / 3 + _TINY


def _cross(a: Floats, b: Floats, result: Floats) -> None:
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]


def _axes_dynamics(constants: Floats, q: Floats, a: Floats, torque: Floats, inertia: Floats) -> None:
    dof = len(q)
    inertia[:] = 0.0
    for i in range(dof):
        weight = (
            constants[dof + i] * math.cos(q[i]) + constants[2 * dof + i] * math.sin(q[i]) + constants[3 * dof + i]
        )
        torque[i] = constants[i] * a[i] + weight
        inertia[i, i] = constants[i] + _TINY


def _arm_dynamics(
    delta: bool,
    constants: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    torque: Floats,
    inertia: Floats,
    workspace: Floats,
) -> None:
    """Torque (dof,) of the arms at one instant, and its derivative by the acceleration, the inertia (dof, dof)."""
    if delta:
        _delta_dynamics(constants, q, v, a, torque, inertia, workspace)
    else:
        _axes_dynamics(constants, q, a, torque, inertia)


def _solve(matrix: Floats, vector: Floats, count: int) -> None:
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


def _elastic_torque(  # noqa: C901 - compiled: one loop
    delta: bool,
    constants: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    compliance: Floats,
    damping_ratio: float,
    dt: float,
    substeps: int,
    beta: float,
) -> Floats:
    """`FlexibleJoints.elastic_torque` (n, dof) by Newmark's method, with `substeps` steps per sample.

    beta: 1/12 (Fox-Goodwin) has the smallest period error; 1/4 (average acceleration) is stable for any step.
    The arms start in static equilibrium, at the beginning and after each gap; NaN where the motion is NaN.
    """
    n, dof = q.shape
    flexible = np.flatnonzero(compliance > 0)
    count = len(flexible)
    result = np.full((n, dof), np.nan)
    torque, inertia, workspace = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    twist, twist_rate, twist_acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    matrix, vector = np.zeros((count, count)), np.zeros(count)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running = dt / substeps, False
    for k in range(n):
        if not (np.isfinite(q[k]).all() and np.isfinite(v[k]).all() and np.isfinite(a[k]).all()):
            running = False
            continue
        if not running:
            twist_rate[:], twist_acceleration[:] = 0.0, 0.0
            for _ in range(_SETTLING_STEPS):
                _arm_dynamics(delta, constants, q[k] - twist, v[k], a[k], torque, inertia, workspace)
                for s in range(count):
                    i = int(flexible[s])
                    twist[i] += 0.5 * (torque[i] * compliance[i] - twist[i])
            running = not np.isnan(twist).any()
            if not running:
                twist[:] = 0.0
                continue
            result[k] = torque
            continue
        for substep in range(1, substeps + 1):
            time_left = dt - substep * h
            for i in range(dof):
                jerk = (a[k, i] - a[k - 1, i]) / dt
                acceleration[i] = a[k, i] - jerk * time_left
                speed[i] = (
                    v[k, i]
                    - a[k, i] * time_left
                    + jerk * time_left**2 / 2
                    - twist_rate[i]
                    - h * twist_acceleration[i]
                )
                position[i] = q[k, i] - v[k, i] * time_left + a[k, i] * time_left**2 / 2 - jerk * time_left**3 / 6
                position[i] -= twist[i] + h * twist_rate[i] + h * h / 2 * twist_acceleration[i]
            _arm_dynamics(delta, constants, position, speed, acceleration, torque, inertia, workspace)
            for s in range(count):
                i = int(flexible[s])
                damping = 2 * damping_ratio * math.sqrt(inertia[i, i] / compliance[i])
                vector[s] = torque[i] - damping * (twist_rate[i] + h / 2 * twist_acceleration[i])
                vector[s] -= (
                    twist[i] + h * twist_rate[i] + h * h * (0.5 - beta) * twist_acceleration[i]
                ) / compliance[i]
                for m in range(count):
                    matrix[s, m] = inertia[i, flexible[m]]
                matrix[s, s] += h / 2 * damping + h * h * beta / compliance[i]
            _solve(matrix, vector, count)
            for s in range(count):
                i = int(flexible[s])
                twist[i] += h * twist_rate[i] + h * h * ((0.5 - beta) * twist_acceleration[i] + beta * vector[s])
                twist_rate[i] += h / 2 * (twist_acceleration[i] + vector[s])
                twist_acceleration[i] = vector[s]
        for i in range(dof):
            result[k, i] = torque[i]
            for m in range(count):
                result[k, i] -= inertia[i, flexible[m]] * twist_acceleration[flexible[m]]
        if np.isnan(result[k]).any():
            running = False
            twist[:] = 0.0
    return result


def _contact_torque(
    torque: Floats, inertia: Floats, free: Bools, gap_acceleration: Floats, matrix: Floats, vector: Floats
) -> None:
    """Compute the `gap_acceleration` of the `free` arms; `torque` becomes the contact torque, 0 for free arms."""
    separated = np.flatnonzero(free)
    count = len(separated)
    for s in range(count):
        vector[s] = torque[separated[s]]
        for m in range(count):
            matrix[s, m] = inertia[separated[s], separated[m]]
    _solve(matrix, vector, count)
    gap_acceleration[:] = 0.0
    for s in range(count):
        gap_acceleration[separated[s]] = vector[s]
    for i in range(len(torque)):
        for m in range(count):
            torque[i] -= inertia[i, separated[m]] * gap_acceleration[separated[m]]
        if free[i]:
            torque[i] = 0.0


def _in_firm_contact(torque: Floats, previous: Floats, x: Floats, half_gap: Floats) -> bool:
    """Return whether all arms stay in contact until the next instant, by linear extrapolation of the torque."""
    for i in range(len(x)):
        if half_gap[i] > 0 and min(torque[i] * x[i], (2 * torque[i] - previous[i]) * x[i]) <= 0:
            return False
    return True


def _backlash_torque(  # noqa: C901 - compiled: one loop
    delta: bool, constants: Floats, q: Floats, v: Floats, a: Floats, half_gap: Floats, dt: float, substeps: int
) -> Floats:
    """`FlexibleJoints.backlash_torque` (n, dof): the mean over each sample, with `substeps` steps per sample.

    An arm is in contact with one side of the gap or moves freely between both. Impacts are inelastic and transfer
    momentum within one step. Arms start in contact on the side of their load; NaN where the motion is NaN.
    """
    n, dof = q.shape
    result = np.full((n, dof), np.nan)
    torque, inertia, workspace = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    mean_torque, rigid_torque, previous = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    matrix, vector = np.zeros((dof, dof)), np.zeros(dof)
    x, w, gap_acceleration, rate_jump, free_share = (
        np.zeros(dof),
        np.zeros(dof),
        np.zeros(dof),
        np.zeros(dof),
        np.zeros(dof),
    )
    free = np.zeros(dof, dtype=np.bool_)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running = dt / substeps, False
    for k in range(n):
        if not (np.isfinite(q[k]).all() and np.isfinite(v[k]).all() and np.isfinite(a[k]).all()):
            running = False
            continue
        if not running:
            _arm_dynamics(delta, constants, q[k], v[k], a[k], torque, inertia, workspace)
            w[:], free[:] = 0.0, False
            for i in range(dof):
                x[i] = half_gap[i] if torque[i] > 0 else -half_gap[i]
            running = True
        mean_torque[:] = 0.0
        if not free.any():
            for i in range(dof):
                position[i] = q[k, i] - x[i]
            _arm_dynamics(delta, constants, position, v[k], a[k], torque, inertia, workspace)
            if _in_firm_contact(torque, previous, x, half_gap):
                result[k], previous[:] = torque, torque
                continue
        for substep in range(substeps):
            offset = (substep + 0.5) * h - dt / 2
            for i in range(dof):
                acceleration[i] = a[k, i]
                speed[i] = v[k, i] + a[k, i] * offset - w[i]
                position[i] = q[k, i] + v[k, i] * offset + a[k, i] * offset**2 / 2 - x[i]
            _arm_dynamics(delta, constants, position, speed, acceleration, torque, inertia, workspace)
            rigid_torque[:] = torque
            _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector)
            released = False
            for i in range(dof):  # contact forces push, they do not pull
                free_share[i] = 1.0
                if half_gap[i] > 0 and not free[i] and torque[i] * x[i] < 0:
                    free_share[i] = (
                        min(torque[i] / (torque[i] - previous[i]), 1.0) if previous[i] * torque[i] < 0 else 1.0
                    )
                    free[i] = released = True
            if released:
                torque[:] = rigid_torque
                _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector)
            mean_torque += torque / substeps
            previous[:] = torque
            contact = False
            for i in range(dof):
                rate_jump[i] = 0.0
                if free[i]:
                    time = free_share[i] * h
                    displacement = time * (w[i] + time * gap_acceleration[i] / 2)
                    side = math.copysign(half_gap[i], displacement)
                    if (x[i] + displacement - side) * side >= 0:
                        share_to_contact = (side - x[i]) / displacement if displacement != 0.0 else 0.0
                        w[i] += share_to_contact * time * gap_acceleration[i]
                        mean_torque[i] += (1 - share_to_contact) * free_share[i] * rigid_torque[i] / substeps
                        x[i], rate_jump[i], free[i], contact = side, -w[i], False, True
                    else:
                        x[i] += displacement
                        w[i] += time * gap_acceleration[i]
            if contact:
                for i in range(dof):  # an impact accelerates the free arms
                    torque[i] = 0.0
                    for m in range(dof):
                        torque[i] -= inertia[i, m] * rate_jump[m]
                _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector)
                mean_torque += torque / dt
                w += rate_jump + gap_acceleration
        result[k] = mean_torque
        if np.isnan(mean_torque).any():
            running = False
    return result


def _dynamics_along(delta: bool, constants: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Torque (n, dof) of the arms if they follow the motors, and the diagonal (n, dof) of their inertia matrix."""
    n, dof = q.shape
    torques, inertias = np.full((n, dof), np.nan), np.full((n, dof), np.nan)
    torque, inertia, workspace = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    for k in range(n):
        _arm_dynamics(delta, constants, q[k], v[k], a[k], torque, inertia, workspace)
        torques[k] = torque
        for i in range(dof):
            inertias[k, i] = inertia[i, i]
    return torques, inertias


_cross = compiled(_cross)
_delta_dynamics = compiled(_delta_dynamics)
_axes_dynamics = compiled(_axes_dynamics)
_arm_dynamics = compiled(_arm_dynamics)
_solve = compiled(_solve)
_contact_torque = compiled(_contact_torque)
_in_firm_contact = compiled(_in_firm_contact)
elastic_torque = compiled(_elastic_torque)
backlash_torque = compiled(_backlash_torque)
dynamics_along = compiled(_dynamics_along)
