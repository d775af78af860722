"""Compiled screening for backlash: each joint alone, with the motion of the other joints unchanged."""

import math

import numpy as np

from ident.basics.numba_cache import compiled
from recordings.recording import Floats


def _backlash_torque(
    load: Floats, gradient: Floats, inertia: Floats, half_gap: float, dt: float, substeps: int
) -> Floats:
    """Torque (n,) by which backlash changes the torque of one arm, with `substeps` steps per sample.

    load: (n,) torque of the arm in the middle of the gap; gradient: (n,) its derivative by the lead of the motor;
    inertia: (n,) [kg m^2] of the arm.
    """
    n = len(load)
    torque = np.zeros(n)
    h, running, free = dt / substeps, False, False
    x = w = 0.0
    for k in range(n):
        if not (math.isfinite(load[k]) and math.isfinite(gradient[k]) and math.isfinite(inertia[k])):
            running = False
            continue
        if not running:
            x, w, free, running = math.copysign(half_gap, load[k]), 0.0, False, True
            continue
        if not free and (load[k] + gradient[k] * x) * x >= 0 and (load[k - 1] + gradient[k - 1] * x) * x >= 0:
            continue
        for substep in range(1, substeps + 1):
            net_torque = load[k - 1] + (load[k] - load[k - 1]) * substep / substeps + gradient[k] * x
            free = free or net_torque * x < 0
            if not free:
                continue
            torque[k] -= net_torque / substeps
            w += h * net_torque / inertia[k]
            x += h * w
            if abs(x) >= half_gap:
                torque[k] += inertia[k] * w / dt
                x, w, free = math.copysign(half_gap, x), 0.0, False
    return torque


@compiled
def cost_reductions(
    load: Floats,
    gradient: Floats,
    inertia: Floats,
    motor_torque: Floats,
    joint_inertias: Floats,
    residual: Floats,
    motor_shares: Floats,
    half_gaps: Floats,
    dt: float,
    substeps: int,
) -> Floats:
    """Reductions (s, h, dof) of the sum of squares of the `residual` (n, dof) by backlash.

    load, gradient, inertia: (n, dof) as in `_backlash_torque`, of arms and motors together.
    motor_torque (n, dof), joint_inertias (dof,): if a motor had all of a joint's own inertia.
    motor_shares: (s,) shares of the motors; half_gaps: (h,) [rad or m].
    """
    n, dof = load.shape
    reductions = np.zeros((len(motor_shares), len(half_gaps), dof))
    for j in range(dof):
        for s in range(len(motor_shares)):
            arm_load = load[:, j] - motor_shares[s] * motor_torque[:, j]
            arm_inertia = np.maximum(inertia[:, j] - motor_shares[s] * joint_inertias[j], 0.01 * inertia[:, j])
            for h in range(len(half_gaps)):
                torque = _backlash_torque(arm_load, gradient[:, j], arm_inertia, half_gaps[h], dt, substeps)
                product = square = 0.0
                for k in range(1, n - 1):
                    smooth = (torque[k - 1] + 2 * torque[k] + torque[k + 1]) / 4
                    if smooth != 0.0 and math.isfinite(residual[k, j]):
                        product += smooth * residual[k, j]
                        square += smooth * smooth
                reductions[s, h, j] = 2 * product - square
    return reductions
