"""Loops of `ident.dynamics.flexible_joints`, compiled as this is imported.

All are in one file: what is kept on disk of a compiled loop is made anew when its own file changes, not when that of
a function which it calls does.

Throughout: `x`, `w` are angle and speed by which motors are ahead of their arms; arms move as motors - x.
"""

import math

import numpy as np

from ident.numba_cache import compiled
from recordings.recording import Bools, Floats

_TINY = 1e-9
"""Inertia [kg m^2] that keeps what has none from dividing by nothing."""
_SETTLING = 50
"""Steps until a spring has found its rest."""


def _delta(  # noqa: C901 - compiled: nothing but numbers in small loops
    numbers: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats, work: Floats
) -> None:
    """Torque (3,) and inertia (3, 3) of a delta's arms: (A3)-(A8), (15)-(16), (23), (26), uniform forearms.

    work: (26, 3), any content.
    """
    L1, L2, out, g = numbers[0], numbers[1], numbers[2], numbers[3]
    m_p, T_g, m_d = numbers[4], numbers[5], numbers[6]
    elbow, tangent, rod, rate, rows, J = work[:3], work[3:6], work[6:9], work[9:12], work[12:15], work[15:18]
    first, second, normal, P, P_dot, P_ddot = work[18], work[19], work[20], work[21], work[22], work[23]
    sines, cosines = work[24], work[25]
    for i in range(3):
        along, across = numbers[7 + i], numbers[10 + i]
        sine, cosine = math.sin(q[i]), math.cos(q[i])
        sines[i], cosines[i] = sine, cosine
        elbow[i, 0], elbow[i, 1], elbow[i, 2] = (out + L1 * cosine) * along, (out + L1 * cosine) * across, L1 * sine
        tangent[i, 0], tangent[i, 1], tangent[i, 2] = -L1 * sine * along, -L1 * sine * across, L1 * cosine
    aa = bb = cc = 0.0
    for d in range(3):
        first[d], second[d] = elbow[1, d] - elbow[0, d], elbow[2, d] - elbow[0, d]
        aa += first[d] ** 2
        bb += second[d] ** 2
        cc += (first[d] - second[d]) ** 2
    _cross(first, second, normal)
    nn = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
    short = L2**2 - aa * bb * cc / (4 * nn)
    if not short >= 0.0:  # torn apart
        torque[:] = np.nan
        inertia[:] = np.nan
        return
    below = math.copysign(math.sqrt(short / nn), normal[2])
    for d in range(3):
        first[d] = aa * second[d] - bb * first[d]
    _cross(first, normal, second)
    for d in range(3):
        P[d] = elbow[0, d] + second[d] / (2 * nn) - below * normal[d]
    for i in range(3):
        for d in range(3):
            rod[i, d] = P[d] - elbow[i, d]
    for i in range(3):  # rows: of the inverse's transpose, not yet divided by the determinant
        _cross(rod[(i + 1) % 3], rod[(i + 2) % 3], rows[i])
    volume = rod[0, 0] * rows[0, 0] + rod[0, 1] * rows[0, 1] + rod[0, 2] * rows[0, 2]
    for i in range(3):
        leverage = rod[i, 0] * tangent[i, 0] + rod[i, 1] * tangent[i, 1] + rod[i, 2] * tangent[i, 2]
        for d in range(3):
            rows[i, d] /= volume
            J[i, d] = rows[i, d] * leverage
    for d in range(3):
        P_dot[d] = J[0, d] * v[0] + J[1, d] * v[1] + J[2, d] * v[2]
        P_ddot[d] = J[0, d] * a[0] + J[1, d] * a[1] + J[2, d] * a[2]
    for i in range(3):
        sine, cosine = sines[i], cosines[i]
        turned = (-L1 * cosine * numbers[7 + i], -L1 * cosine * numbers[10 + i], -L1 * sine)
        curvature = 0.0
        for d in range(3):
            rate[i, d] = P_dot[d] - tangent[i, d] * v[i]
            curvature += (rate[i, d] * tangent[i, d] + rod[i, d] * turned[d] * v[i]) * v[i] - rate[i, d] * P_dot[d]
        for d in range(3):
            P_ddot[d] += rows[i, d] * curvature
    P_ddot[2] += g  # from here on with what carries the weight
    pull = first
    for d in range(3):
        pull[d] = (m_p + m_d) * P_ddot[d]
    for i in range(3):
        sine, cosine = sines[i], cosines[i]
        turned = (-L1 * cosine * numbers[7 + i], -L1 * cosine * numbers[10 + i], -L1 * sine)
        torque[i] = T_g * cosine + numbers[13 + i] * a[i]
        for d in range(3):
            at = tangent[i, d] * a[i] + turned[d] * v[i] ** 2 + (g if d == 2 else 0.0)
            torque[i] += m_d * tangent[i, d] * (2 * at + P_ddot[d]) / 6
            pull[d] += m_d * at / 6
    for i in range(3):
        torque[i] += J[i, 0] * pull[0] + J[i, 1] * pull[1] + J[i, 2] * pull[2]
        for j in range(3):
            inertia[i, j] = 0.0
            for d in range(3):
                inertia[i, j] += (m_p + m_d) * J[i, d] * J[j, d]
                inertia[i, j] += m_d * (tangent[i, d] * J[j, d] + J[i, d] * tangent[j, d]) / 6
        inertia[i, i] += numbers[13 + i] + m_d * L1**2 / 3 + _TINY


def _cross(a: Floats, b: Floats, result: Floats) -> None:
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]


def _axes(numbers: Floats, q: Floats, a: Floats, torque: Floats, inertia: Floats) -> None:
    dof = len(q)
    inertia[:] = 0.0
    for i in range(dof):
        weight = numbers[dof + i] * math.cos(q[i]) + numbers[2 * dof + i] * math.sin(q[i]) + numbers[3 * dof + i]
        torque[i] = numbers[i] * a[i] + weight
        inertia[i, i] = numbers[i] + _TINY


def _arms(
    delta: bool, numbers: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats, work: Floats
) -> None:
    """Torque (dof,) of the arms at one instant, and inertia (dof, dof), its derivative by the acceleration."""
    if delta:
        _delta(numbers, q, v, a, torque, inertia, work)
    else:
        _axes(numbers, q, a, torque, inertia)


def _solve(matrix: Floats, right: Floats, count: int) -> None:
    """`right` becomes the solution, by elimination; the matrix (count, count) is positive definite, and spoilt."""
    for i in range(count):
        for j in range(i + 1, count):
            part = matrix[j, i] / matrix[i, i]
            right[j] -= part * right[i]
            for m in range(i, count):
                matrix[j, m] -= part * matrix[i, m]
    for i in range(count - 1, -1, -1):
        for j in range(i + 1, count):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]


def _on_springs(  # noqa: C901 - compiled: one loop
    delta: bool,
    numbers: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    compliance: Floats,
    ratio: float,
    dt: float,
    parts: int,
    beta: float,
) -> Floats:
    """`Arms.on_springs`, by Newmark's method, `parts` steps to an instant.

    beta: 1/12 (Fox, Goodwin) has no error of the period to speak of, 1/4 (mean acceleration) bears any step.
    It starts at rest on the springs; NaN where the motion is. After a gap it starts anew.
    """
    n, dof = q.shape
    soft = np.flatnonzero(compliance > 0)
    count = len(soft)
    result = np.full((n, dof), np.nan)
    torque, inertia, work = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    x, w, bend = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    matrix, right = np.zeros((count, count)), np.zeros(count)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running = dt / parts, False
    for k in range(n):
        if not (np.isfinite(q[k]).all() and np.isfinite(v[k]).all() and np.isfinite(a[k]).all()):
            running = False
            continue
        if not running:
            w[:], bend[:] = 0.0, 0.0
            for _ in range(_SETTLING):
                _arms(delta, numbers, q[k] - x, v[k], a[k], torque, inertia, work)
                for s in range(count):
                    i = int(soft[s])
                    x[i] += 0.5 * (torque[i] * compliance[i] - x[i])
            running = not np.isnan(x).any()
            if not running:
                x[:] = 0.0
                continue
            result[k] = torque
            continue
        for part in range(1, parts + 1):
            back = dt - part * h
            for i in range(dof):
                jerk = (a[k, i] - a[k - 1, i]) / dt
                acceleration[i] = a[k, i] - jerk * back
                speed[i] = v[k, i] - a[k, i] * back + jerk * back**2 / 2 - w[i] - h * bend[i]
                position[i] = q[k, i] - v[k, i] * back + a[k, i] * back**2 / 2 - jerk * back**3 / 6
                position[i] -= x[i] + h * w[i] + h * h / 2 * bend[i]
            _arms(delta, numbers, position, speed, acceleration, torque, inertia, work)
            for s in range(count):
                i = int(soft[s])
                damping = 2 * ratio * math.sqrt(inertia[i, i] / compliance[i])
                right[s] = torque[i] - damping * (w[i] + h / 2 * bend[i])
                right[s] -= (x[i] + h * w[i] + h * h * (0.5 - beta) * bend[i]) / compliance[i]
                for m in range(count):
                    matrix[s, m] = inertia[i, soft[m]]
                matrix[s, s] += h / 2 * damping + h * h * beta / compliance[i]
            _solve(matrix, right, count)
            for s in range(count):
                i = int(soft[s])
                x[i] += h * w[i] + h * h * ((0.5 - beta) * bend[i] + beta * right[s])
                w[i] += h / 2 * (bend[i] + right[s])
                bend[i] = right[s]
        for i in range(dof):
            result[k, i] = torque[i]
            for m in range(count):
                result[k, i] -= inertia[i, soft[m]] * bend[soft[m]]
        if np.isnan(result[k]).any():
            running = False
            x[:] = 0.0
    return result


def _forces(torque: Floats, inertia: Floats, free: Bools, bend: Floats, matrix: Floats, right: Floats) -> None:
    """`bend`: acceleration of x of those that fly; `torque` becomes what the others are given, and 0 for those."""
    flying = np.flatnonzero(free)
    count = len(flying)
    for s in range(count):
        right[s] = torque[flying[s]]
        for m in range(count):
            matrix[s, m] = inertia[flying[s], flying[m]]
    _solve(matrix, right, count)
    bend[:] = 0.0
    for s in range(count):
        bend[flying[s]] = right[s]
    for i in range(len(torque)):
        for m in range(count):
            torque[i] -= inertia[i, flying[m]] * bend[flying[m]]
        if free[i]:
            torque[i] = 0.0


def _firm(torque: Floats, last: Floats, x: Floats, half: Floats) -> bool:
    """Whether the sides of the gap on which arms rest push them, and will until the next instant."""
    for i in range(len(x)):
        if half[i] > 0 and min(torque[i] * x[i], (2 * torque[i] - last[i]) * x[i]) <= 0:
            return False
    return True


def _with_play(  # noqa: C901 - compiled: one loop
    delta: bool, numbers: Floats, q: Floats, v: Floats, a: Floats, half: Floats, dt: float, parts: int
) -> Floats:
    """`Arms.with_play`: mean over the time of each instant, `parts` steps to one.

    An arm is pushed by one side of the gap, or flies freely between both; teeth hit without bounce, and a joint that
    is hit is given what that takes within one step. It starts where the load pushes it; NaN where the motion is.
    """
    n, dof = q.shape
    result = np.full((n, dof), np.nan)
    torque, inertia, work = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    given, whole, last = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    matrix, right = np.zeros((dof, dof)), np.zeros(dof)
    x, w, bend, blow, flown = np.zeros(dof), np.zeros(dof), np.zeros(dof), np.zeros(dof), np.zeros(dof)
    free = np.zeros(dof, dtype=np.bool_)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running = dt / parts, False
    for k in range(n):
        if not (np.isfinite(q[k]).all() and np.isfinite(v[k]).all() and np.isfinite(a[k]).all()):
            running = False
            continue
        if not running:
            _arms(delta, numbers, q[k], v[k], a[k], torque, inertia, work)
            w[:], free[:] = 0.0, False
            for i in range(dof):
                x[i] = half[i] if torque[i] > 0 else -half[i]
            running = True
        given[:] = 0.0
        if not free.any():
            for i in range(dof):
                position[i] = q[k, i] - x[i]
            _arms(delta, numbers, position, v[k], a[k], torque, inertia, work)
            if _firm(torque, last, x, half):
                result[k], last[:] = torque, torque
                continue
        for part in range(parts):
            aside = (part + 0.5) * h - dt / 2
            for i in range(dof):
                acceleration[i] = a[k, i]
                speed[i] = v[k, i] + a[k, i] * aside - w[i]
                position[i] = q[k, i] + v[k, i] * aside + a[k, i] * aside**2 / 2 - x[i]
            _arms(delta, numbers, position, speed, acceleration, torque, inertia, work)
            whole[:] = torque
            _forces(torque, inertia, free, bend, matrix, right)
            released = False
            for i in range(dof):  # teeth push, they do not pull
                flown[i] = 1.0
                if half[i] > 0 and not free[i] and torque[i] * x[i] < 0:
                    flown[i] = min(torque[i] / (torque[i] - last[i]), 1.0) if last[i] * torque[i] < 0 else 1.0
                    free[i] = released = True
            if released:
                torque[:] = whole
                _forces(torque, inertia, free, bend, matrix, right)
            given += torque / parts
            last[:] = torque
            hits = False
            for i in range(dof):
                blow[i] = 0.0
                if free[i]:
                    time = flown[i] * h
                    way = time * (w[i] + time * bend[i] / 2)
                    side = math.copysign(half[i], way)
                    if (x[i] + way - side) * side >= 0:
                        part_flown = (side - x[i]) / way if way != 0.0 else 0.0
                        w[i] += part_flown * time * bend[i]
                        given[i] += (1 - part_flown) * flown[i] * whole[i] / parts
                        x[i], blow[i], free[i], hits = side, -w[i], False, True
                    else:
                        x[i] += way
                        w[i] += time * bend[i]
            if hits:
                for i in range(dof):  # what is hit pulls at what flies, as if it were accelerated
                    torque[i] = 0.0
                    for m in range(dof):
                        torque[i] -= inertia[i, m] * blow[m]
                _forces(torque, inertia, free, bend, matrix, right)
                given += torque / dt
                w += blow + bend
        result[k] = given
        if np.isnan(given).any():
            running = False
    return result


def _along(delta: bool, numbers: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Torque (n, dof) of the arms if they follow the motors, and the diagonal (n, dof) of their inertia."""
    n, dof = q.shape
    torques, inertias = np.full((n, dof), np.nan), np.full((n, dof), np.nan)
    torque, inertia, work = np.zeros(dof), np.zeros((dof, dof)), np.zeros((26, 3))
    for k in range(n):
        _arms(delta, numbers, q[k], v[k], a[k], torque, inertia, work)
        torques[k] = torque
        for i in range(dof):
            inertias[k, i] = inertia[i, i]
    return torques, inertias


_cross = compiled(_cross)
_delta = compiled(_delta)
_axes = compiled(_axes)
_arms = compiled(_arms)
_solve = compiled(_solve)
_forces = compiled(_forces)
_firm = compiled(_firm)
on_springs = compiled(_on_springs)
with_play = compiled(_with_play)
along = compiled(_along)
