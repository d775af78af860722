"""Compiled motion of arms behind springs.

The twist of a joint is the angle by which the motor is ahead of the arm.
"""

import math

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.arm_kernels import arm_dynamics, known, solve
from recordings.recording import Floats

_SETTLING_STEPS = 50
"""Iterations to the initial static twist."""


@compiled
def elastic_torque(  # noqa: C901 - compiled: one loop
    kind: int,
    constants: Floats,
    q: Floats,
    v: Floats,
    a: Floats,
    load: Floats,
    compliance: Floats,
    damping_ratio: float,
    dt: float,
    substeps: int,
    beta: Floats,
) -> Floats:
    """`FlexibleJoints.elastic_torque` (n, dof) by Newmark's method, with `substeps` steps per sample.

    load: (n, dof) further torque of the arms, along the motors' motion.
    beta: (dof,) of each joint: 1/12 (Fox-Goodwin) has the smallest period error; 1/4 (average acceleration) is stable
        for any step.
    The arms start in static equilibrium, at the beginning and after each gap; NaN where the motion is NaN.
    """
    n, dof = q.shape
    flexible = np.flatnonzero(compliance > 0)
    count = len(flexible)
    result = np.full((n, dof), np.nan)
    torque, inertia = np.zeros(dof), np.zeros((dof, dof))
    twist, twist_rate, twist_acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    matrix, vector = np.zeros((count, count)), np.zeros(count)
    position, speed, acceleration = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    h, running = dt / substeps, False
    for k in range(n):
        if not known(q, v, a, k):
            running = False
            continue
        if not running:
            twist_rate[:], twist_acceleration[:] = 0.0, 0.0
            for _ in range(_SETTLING_STEPS):
                arm_dynamics(kind, constants, q[k] - twist, v[k], a[k], torque, inertia)
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
            arm_dynamics(kind, constants, position, speed, acceleration, torque, inertia)
            for i in range(dof):
                torque[i] += load[k, i] - (load[k, i] - load[k - 1, i]) * (time_left / dt)
            for s in range(count):
                i = int(flexible[s])
                damping = 2 * damping_ratio * math.sqrt(inertia[i, i] / compliance[i])
                vector[s] = torque[i] - damping * (twist_rate[i] + h / 2 * twist_acceleration[i])
                vector[s] -= (
                    twist[i] + h * twist_rate[i] + h * h * (0.5 - beta[i]) * twist_acceleration[i]
                ) / compliance[i]
                for m in range(count):
                    matrix[s, m] = inertia[i, flexible[m]]
                matrix[s, s] += h / 2 * damping + h * h * beta[i] / compliance[i]
            solve(matrix, vector, count)
            for s in range(count):
                i = int(flexible[s])
                twist[i] += h * twist_rate[i] + h * h * (
                    (0.5 - beta[i]) * twist_acceleration[i] + beta[i] * vector[s]
                )
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
