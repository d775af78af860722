"""Compiled motion of arms behind gears with backlash.

The twist `x` of a joint is the angle by which the motor is ahead of the arm, and `w` its derivative.
"""

import math

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.arm_kernels import arm_dynamics, known, solve
from recordings.recording import Bools, Floats, Ints

_TINY = 1e-9
"""Shortest impact [s]."""


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
    solve(matrix, vector, count)
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


@compiled
def backlash_torque(  # noqa: C901 - compiled: one loop
    kind: int,
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
    torque, inertia = np.zeros(dof), np.zeros((dof, dof))
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
        if not known(q, v, a, k):
            running = False
            continue
        if not running:
            arm_dynamics(kind, constants, q[k], v[k], a[k], torque, inertia)
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
            arm_dynamics(kind, constants, position, speed, acceleration, torque, inertia)
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
            arm_dynamics(kind, constants, position, speed, acceleration, torque, inertia)
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
