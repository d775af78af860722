"""Compiled kernels of `ident.dynamics.flexible_joints` and `ident.dynamics.platform`.

All are in one file: numba recompiles a cached function when its own file changes, but not when the file of a function
changes that it calls.

The twist of a joint, `twist` or `x`, is the angle by which the motor is ahead of the arm; `twist_rate` or `w` is its
derivative.
"""

import math

import numpy as np

from ident.numba_cache import compiled
from recordings.recording import Bools, Floats, Ints

_TINY = 1e-9
"""Added to every inertia [kg m^2] so that none is zero."""
_SETTLING_STEPS = 50
"""Iterations to the initial static twist."""
_ELBOW, _TANGENT, _ROD, _ROD_RATE, _ROWS, _J = 0, 3, 6, 9, 12, 15
"""First rows of 3 x 3 matrices in the workspace of `_delta_dynamics`."""
_FIRST, _SECOND, _NORMAL, _P, _P_DOT, _P_DDOT, _SINES, _COSINES = range(18, 26)
"""Rows of vectors in it."""


def _delta_dynamics(  # noqa: C901 - compiled: nothing but numbers in small loops
    constants: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats, w: Floats
) -> None:
    """Torque (3,) and inertia (3, 3) of a delta's arms: (A3)-(A8), (15)-(16), (23), (26), with uniform rods.

    w: (26, 3), any content; a workspace, of which no views are made: they take longer than the sums.
    """
    L1, L2, out, g = constants[0], constants[1], constants[2], constants[3]
    m_p, T_g, m_d = constants[4], constants[5], constants[6]
    platform_mass, sixth = m_p + m_d, m_d / 6
    for i in range(3):
        cos_phi, sin_phi = constants[7 + i], constants[10 + i]
        sine, cosine = math.sin(q[i]), math.cos(q[i])
        w[_SINES, i], w[_COSINES, i] = sine, cosine
        w[_ELBOW + i, 0], w[_ELBOW + i, 1], w[_ELBOW + i, 2] = (
            (out + L1 * cosine) * cos_phi,
            (out + L1 * cosine) * sin_phi,
            L1 * sine,
        )
        w[_TANGENT + i, 0], w[_TANGENT + i, 1], w[_TANGENT + i, 2] = (
            -L1 * sine * cos_phi,
            -L1 * sine * sin_phi,
            L1 * cosine,
        )
    aa = bb = cc = 0.0
    for d in range(3):
        w[_FIRST, d], w[_SECOND, d] = w[_ELBOW + 1, d] - w[_ELBOW, d], w[_ELBOW + 2, d] - w[_ELBOW, d]
        aa += w[_FIRST, d] ** 2
        bb += w[_SECOND, d] ** 2
        cc += (w[_FIRST, d] - w[_SECOND, d]) ** 2
    _cross(w, _FIRST, _SECOND, _NORMAL)
    nn = w[_NORMAL, 0] ** 2 + w[_NORMAL, 1] ** 2 + w[_NORMAL, 2] ** 2
    height_squared = L2**2 - aa * bb * cc / (4 * nn)
    if not height_squared >= 0.0:  # no position closes the loop
        torque[:] = np.nan
        inertia[:] = np.nan
        return
    drop = math.copysign(math.sqrt(height_squared / nn), w[_NORMAL, 2])
    for d in range(3):
        w[_FIRST, d] = aa * w[_SECOND, d] - bb * w[_FIRST, d]
    _cross(w, _FIRST, _NORMAL, _SECOND)
    share = 0.5 / nn
    for d in range(3):
        w[_P, d] = w[_ELBOW, d] + w[_SECOND, d] * share - drop * w[_NORMAL, d]
    for i in range(3):
        for d in range(3):
            w[_ROD + i, d] = w[_P, d] - w[_ELBOW + i, d]
    for i in range(3):  # rows of the transposed inverse, not yet divided by the determinant
        _cross(w, _ROD + (i + 1) % 3, _ROD + (i + 2) % 3, _ROWS + i)
    by_determinant = 1 / (w[_ROD, 0] * w[_ROWS, 0] + w[_ROD, 1] * w[_ROWS, 1] + w[_ROD, 2] * w[_ROWS, 2])
    for i in range(3):
        leverage = 0.0
        for d in range(3):
            leverage += w[_ROD + i, d] * w[_TANGENT + i, d]
        for d in range(3):
            w[_ROWS + i, d] *= by_determinant
            w[_J + i, d] = w[_ROWS + i, d] * leverage
    for d in range(3):
        w[_P_DOT, d] = w[_J, d] * v[0] + w[_J + 1, d] * v[1] + w[_J + 2, d] * v[2]
        w[_P_DDOT, d] = w[_J, d] * a[0] + w[_J + 1, d] * a[1] + w[_J + 2, d] * a[2]
    for i in range(3):
        sine, cosine = w[_SINES, i], w[_COSINES, i]
        tangent_derivative = (-L1 * cosine * constants[7 + i], -L1 * cosine * constants[10 + i], -L1 * sine)
        curvature = 0.0
        for d in range(3):
            w[_ROD_RATE + i, d] = w[_P_DOT, d] - w[_TANGENT + i, d] * v[i]
            bend = w[_ROD_RATE + i, d] * w[_TANGENT + i, d] + w[_ROD + i, d] * tangent_derivative[d] * v[i]
            curvature += bend * v[i] - w[_ROD_RATE + i, d] * w[_P_DOT, d]
        for d in range(3):
            w[_P_DDOT, d] += w[_ROWS + i, d] * curvature
    w[_P_DDOT, 2] += g  # from here on minus gravity
    for d in range(3):
        w[_FIRST, d] = platform_mass * w[_P_DDOT, d]
    for i in range(3):
        sine, cosine = w[_SINES, i], w[_COSINES, i]
        tangent_derivative = (-L1 * cosine * constants[7 + i], -L1 * cosine * constants[10 + i], -L1 * sine)
        total = T_g * cosine + constants[13 + i] * a[i]
        for d in range(3):
            elbow_acceleration = (
                w[_TANGENT + i, d] * a[i] + tangent_derivative[d] * v[i] ** 2 + (g if d == 2 else 0.0)
            )
            total += sixth * w[_TANGENT + i, d] * (2 * elbow_acceleration + w[_P_DDOT, d])
            w[_FIRST, d] += sixth * elbow_acceleration
        torque[i] = total
    for i in range(3):
        torque[i] += w[_J + i, 0] * w[_FIRST, 0] + w[_J + i, 1] * w[_FIRST, 1] + w[_J + i, 2] * w[_FIRST, 2]
        for j in range(i + 1):
            total = 0.0
            for d in range(3):
                total += platform_mass * w[_J + i, d] * w[_J + j, d]
                total += sixth * (w[_TANGENT + i, d] * w[_J + j, d] + w[_J + i, d] * w[_TANGENT + j, d])
            inertia[i, j] = inertia[j, i] = total
        inertia[i, i] += constants[13 + i] + m_d * L1**2 / 3 + _TINY


def _cross(w: Floats, a: int, b: int, result: int) -> None:
    """Row `result` of `w` becomes the cross product of the rows `a` and `b`."""
    w[result, 0] = w[a, 1] * w[b, 2] - w[a, 2] * w[b, 1]
    w[result, 1] = w[a, 2] * w[b, 0] - w[a, 0] * w[b, 2]
    w[result, 2] = w[a, 0] * w[b, 1] - w[a, 1] * w[b, 0]


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


def _known(q: Floats, v: Floats, a: Floats, k: int) -> bool:
    for i in range(q.shape[1]):
        if not (math.isfinite(q[k, i]) and math.isfinite(v[k, i]) and math.isfinite(a[k, i])):
            return False
    return True


def _elastic_torque(  # noqa: C901 - compiled: one loop
    delta: bool,
    constants: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    load: Floats,
    compliance: Floats,
    damping_ratio: float,
    dt: float,
    substeps: int,
    beta: float,
) -> Floats:
    """`FlexibleJoints.elastic_torque` (n, dof) by Newmark's method, with `substeps` steps per sample.

    load: (n, dof) further torque of the arms, along the motors' motion.
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
        if not _known(q, v, a, k):
            running = False
            continue
        if not running:
            twist_rate[:], twist_acceleration[:] = 0.0, 0.0
            for _ in range(_SETTLING_STEPS):
                _arm_dynamics(delta, constants, q[k] - twist, v[k], a[k], torque, inertia, workspace)
                torque += load[k]
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
            for i in range(dof):
                torque[i] += load[k, i] - (load[k, i] - load[k - 1, i]) * (time_left / dt)
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
            if math.isnan(result[k, i]):
                running = False
        if not running:
            twist[:] = 0.0
    return result


def _contact_torque(
    torque: Floats,
    inertia: Floats,
    free: Bools,
    gap_acceleration: Floats,
    matrix: Floats,
    vector: Floats,
    separated: Ints,
) -> None:
    """Compute the `gap_acceleration` of the `free` arms; `torque` becomes the contact torque, 0 for free arms.

    matrix, vector, separated: (dof, dof), (dof,) and (dof,), any content.
    """
    count = 0
    for i in range(len(torque)):
        gap_acceleration[i] = 0.0
        if free[i]:
            separated[count] = i
            count += 1
    if count == 0:
        return
    for s in range(count):
        vector[s] = torque[separated[s]]
        for m in range(count):
            matrix[s, m] = inertia[separated[s], separated[m]]
    _solve(matrix, vector, count)
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
    delta: bool,
    constants: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    load: Floats,
    half_gap: Floats,
    impact: float,
    delay: float,
    dt: float,
    substeps: int,
) -> Floats:
    """`FlexibleJoints.backlash_torque` (n, dof): the mean over each sample, with `substeps` steps per sample.

    An arm is in contact with one side of the gap or moves freely between both. Impacts are inelastic. Arms take on
    their new speed within one step, but the torque of the impact is spread over the time `impact` [s] around the
    contact (at most one sample), or the `delay` [s] later: if all of it fell into the sample of the contact, it would
    jump to the next one as the gap grows, and a search over the gap would be stuck between such jumps.
    load: (n, dof) further torque of the arms, along the motors' motion.
    Arms start in contact on the side of their load; NaN where the motion is NaN.
    """
    n, dof = q.shape
    result, impacts = np.full((n, dof), np.nan), np.zeros((n, dof))
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
    free, separated = np.zeros(dof, dtype=np.bool_), np.zeros(dof, dtype=np.int64)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running, spread = dt / substeps, False, min(max(impact, _TINY), dt)
    for k in range(n):
        if not _known(q, v, a, k):
            running = False
            continue
        if not running:
            _arm_dynamics(delta, constants, q[k], v[k], a[k], torque, inertia, workspace)
            torque += load[k]
            w[:], free[:] = 0.0, False
            for i in range(dof):
                x[i] = half_gap[i] if torque[i] > 0 else -half_gap[i]
            running = True
        any_free = False
        for i in range(dof):
            mean_torque[i] = 0.0
            any_free = any_free or free[i]
        if not any_free:
            for i in range(dof):
                position[i], speed[i], acceleration[i] = q[k, i] - x[i], v[k, i], a[k, i]
            _arm_dynamics(delta, constants, position, speed, acceleration, torque, inertia, workspace)
            torque += load[k]
            if _in_firm_contact(torque, previous, x, half_gap):
                for i in range(dof):
                    result[k, i] = previous[i] = torque[i]
                continue
        for substep in range(substeps):
            offset = (substep + 0.5) * h - dt / 2
            beside_k = min(max(k + (1 if offset > 0 else -1), 0), n - 1)
            for i in range(dof):
                neighbor = a[beside_k, i]
                jerk = (neighbor - a[k, i]) / dt if offset > 0 else (a[k, i] - neighbor) / dt
                jerk = jerk if math.isfinite(jerk) else 0.0
                acceleration[i] = a[k, i] + jerk * offset
                speed[i] = v[k, i] + a[k, i] * offset + jerk * offset**2 / 2 - w[i]
                position[i] = q[k, i] + v[k, i] * offset + a[k, i] * offset**2 / 2 + jerk * offset**3 / 6 - x[i]
            _arm_dynamics(delta, constants, position, speed, acceleration, torque, inertia, workspace)
            for i in range(dof):
                change = load[beside_k, i] - load[k, i]
                torque[i] += load[k, i] + (change * abs(offset) / dt if math.isfinite(change) else 0.0)
                rigid_torque[i] = torque[i]
            _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector, separated)
            released = False
            for i in range(dof):  # contact forces push, they do not pull
                free_share[i] = 1.0
                if half_gap[i] > 0 and not free[i] and torque[i] * x[i] < 0:
                    free_share[i] = (
                        min(torque[i] / (torque[i] - previous[i]), 1.0) if previous[i] * torque[i] < 0 else 1.0
                    )
                    free[i] = released = True
            if released:
                for i in range(dof):
                    torque[i] = rigid_torque[i]
                _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector, separated)
            for i in range(dof):
                mean_torque[i] += torque[i] / substeps
                previous[i] = torque[i]
            contact, contact_time = False, 0.0
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
                        contact_time = offset + h / 2 - (1 - share_to_contact) * time
                    else:
                        x[i] += displacement
                        w[i] += time * gap_acceleration[i]
            if contact:
                for i in range(dof):  # an impact accelerates the free arms
                    torque[i] = 0.0
                    for m in range(dof):
                        torque[i] -= inertia[i, m] * rate_jump[m]
                _contact_torque(torque, inertia, free, gap_acceleration, matrix, vector, separated)
                centre = contact_time + delay
                sample = round(centre / dt)
                beside = centre - sample * dt
                share = max((abs(beside) - (dt - spread) / 2) / spread, 0.0)
                sample += k
                for weight, target in ((1 - share, sample), (share, sample + (1 if beside > 0 else -1))):
                    if 0 <= target < n:
                        impacts[target] += weight * torque / dt
                w += rate_jump + gap_acceleration
        for i in range(dof):
            result[k, i] = mean_torque[i]
            running = running and not math.isnan(mean_torque[i])
    return result + impacts


def _dynamics_along(delta: bool, constants: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Torque (n, dof) of the arms if they follow the motors, and the diagonal (n, dof) of their inertia matrix."""
    n, dof = q.shape
    torques, inertias = np.full((n, dof), np.nan), np.full((n, dof), np.nan)
    torque, inertia, workspace = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    for k in range(n):
        for i in range(dof):
            position[i], speed[i], acceleration[i] = q[k, i], v[k, i], a[k, i]
        _arm_dynamics(delta, constants, position, speed, acceleration, torque, inertia, workspace)
        for i in range(dof):
            torques[k, i], inertias[k, i] = torque[i], inertia[i, i]
    return torques, inertias


def _platform_along(
    constants: Floats, q: Floats, v: Floats, a: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Position, velocity and acceleration (n, 3) of a delta's platform, its Jacobian (n, 3, 3), and torque (n, 3)."""
    n = len(q)
    position, velocity, acceleration, jacobian = (
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((n, 3, 3)),
    )
    torques = np.empty((n, 3))
    torque, inertia, workspace = np.zeros(3), np.zeros((3, 3)), np.zeros((26, 3))
    for k in range(n):
        workspace[:] = np.nan
        _delta_dynamics(constants, q[k], v[k], a[k], torque, inertia, workspace)
        for d in range(3):
            position[k, d], velocity[k, d] = workspace[_P, d], workspace[_P_DOT, d]
            acceleration[k, d] = workspace[_P_DDOT, d] - (constants[3] if d == 2 else 0.0)
            torques[k, d] = torque[d]
            for i in range(3):
                jacobian[k, d, i] = workspace[_J + i, d]
    return position, velocity, acceleration, jacobian, torques


_known = compiled(_known)
_cross = compiled(_cross)
_delta_dynamics = compiled(_delta_dynamics, error_model="numpy")
_axes_dynamics = compiled(_axes_dynamics)
_arm_dynamics = compiled(_arm_dynamics)
_solve = compiled(_solve, error_model="numpy")
_contact_torque = compiled(_contact_torque)
_in_firm_contact = compiled(_in_firm_contact)
elastic_torque = compiled(_elastic_torque)
backlash_torque = compiled(_backlash_torque)
dynamics_along = compiled(_dynamics_along)
platform_along = compiled(_platform_along, error_model="numpy")
