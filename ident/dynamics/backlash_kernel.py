"""Compiled motion of arms behind gears with backlash.

The twist `x` of a joint is the angle by which the motor is ahead of the arm, and `w` its derivative.
"""

import math

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.arm_kernels import solve
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


def _in_firm_contact(torque: Floats, previous: Floats, x: Floats) -> bool:
    """Return whether all arms stay in contact until the next instant, by linear extrapolation of the torque."""
    return bool((np.minimum(torque * x, (2 * torque - previous) * x) > 0).all())


@compiled
def backlash_twists(  # noqa: C901 - compiled: one loop
    torque: Floats,
    K: Floats,
    C: Floats,
    M: Floats,
    half_gap: Floats,
    impact: float,
    delay: float,
    dt: float,
    substeps: int,
) -> Floats:
    """Twists x, x' and x'' (3, n, f) of arms with backlash: means over each sample, with `substeps` steps per sample.

    An arm is in contact with one side of the gap or moves freely between both. Impacts are inelastic. Arms take on
    their new speed within one step, but the acceleration of the impact is spread over the time `impact` [s] around
    the contact (at most one sample), or the `delay` [s] later: if all of it fell into the sample of the contact, it
    would jump to the next one as the gap grows, and a search over the gap would be stuck between such jumps.
    torque (n, f), K, C, M (n, f, f): of arms that follow the motors, and its derivatives; half_gap: (f,), none is 0.
    Arms start in contact on the side of their load; NaN where the torque is NaN.
    """
    n, count = torque.shape
    twists, impacts = np.full((3, n, count), np.nan), np.zeros((n, count))
    contact, rigid, previous, inertia = np.zeros(count), np.zeros(count), np.zeros(count), np.zeros((count, count))
    matrix, vector = np.zeros((count, count)), np.zeros(count)
    x, w, gap_acceleration, jump, free_share = (
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count),
    )
    free, separated = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.int64)
    h, running, spread = dt / substeps, False, min(max(impact, _TINY), dt)
    for k in range(n):
        if np.isnan(torque[k]).any():
            running = False
            continue
        if not running:
            x[:], w[:], free[:] = np.where(torque[k] > 0, half_gap, -half_gap), 0.0, False
            running = True
        twists[:, k] = 0.0
        if not free.any():
            for i in range(count):
                contact[i] = torque[k, i]
                for m in range(count):
                    contact[i] -= K[k, i, m] * x[m]
            if _in_firm_contact(contact, previous, x):
                twists[0, k], previous[:] = x, contact
                continue
        for substep in range(substeps):
            offset = (substep + 0.5) * h - dt / 2
            beside_k = min(max(k + (1 if offset > 0 else -1), 0), n - 1)
            far = 0.0 if np.isnan(torque[beside_k]).any() else abs(offset) / dt
            for i in range(count):
                rigid[i] = (1 - far) * torque[k, i] + (far * torque[beside_k, i] if far else 0.0)
                for m in range(count):
                    inertia[i, m] = (1 - far) * M[k, i, m] + far * M[beside_k, i, m]
                    rigid[i] -= K[k, i, m] * x[m] + C[k, i, m] * w[m]
                contact[i] = rigid[i]
            _contact_torque(contact, inertia, free, gap_acceleration, matrix, vector, separated)
            released = False
            for i in range(count):  # contact forces push, they do not pull
                free_share[i] = 1.0
                if not free[i] and contact[i] * x[i] < 0:
                    free_share[i] = (
                        min(contact[i] / (contact[i] - previous[i]), 1.0) if previous[i] * contact[i] < 0 else 1.0
                    )
                    free[i] = released = True
            if released:
                contact[:] = rigid
                _contact_torque(contact, inertia, free, gap_acceleration, matrix, vector, separated)
            previous[:] = contact
            hit, contact_time = False, 0.0
            for i in range(count):
                jump[i] = 0.0
                twists[0, k, i] += x[i] / substeps
                twists[1, k, i] += w[i] / substeps
                if free[i]:
                    time = free_share[i] * h
                    displacement = time * (w[i] + time * gap_acceleration[i] / 2)
                    side = math.copysign(half_gap[i], displacement)
                    flight = time
                    if (x[i] + displacement - side) * side >= 0:
                        share_to_contact = (side - x[i]) / displacement if displacement != 0.0 else 0.0
                        flight = share_to_contact * time
                        x[i], jump[i] = side, -(w[i] + flight * gap_acceleration[i])
                        free[i], hit, contact_time = False, True, offset + h / 2 - (time - flight)
                    else:
                        x[i] += displacement
                    w[i] += flight * gap_acceleration[i]
                    twists[2, k, i] += flight * gap_acceleration[i] / dt
            if hit:
                for i in range(count):  # an impact accelerates the free arms
                    contact[i] = 0.0
                    for m in range(count):
                        contact[i] -= inertia[i, m] * jump[m]
                _contact_torque(contact, inertia, free, gap_acceleration, matrix, vector, separated)
                jump += gap_acceleration
                centre = contact_time + delay
                sample = round(centre / dt)
                beside = centre - sample * dt
                share = max((abs(beside) - (dt - spread) / 2) / spread, 0.0)
                sample += k
                for weight, target in ((1 - share, sample), (share, sample + (1 if beside > 0 else -1))):
                    if 0 <= target < n:
                        impacts[target] += weight * jump / dt
                w += jump
    twists[2] += impacts
    return twists
