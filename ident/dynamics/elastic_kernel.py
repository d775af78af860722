"""Compiled motion of arms behind springs.

The twist of a joint is the angle by which the motor is ahead of the arm.
"""

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.arm_kernels import solve
from recordings.recording import Floats


@compiled
def spring_twists(torque: Floats, K: Floats, C: Floats, M: Floats, dt: float, substeps: int, beta: float) -> Floats:
    """Solve M x'' + C x' + K x = torque by Newmark's method, with `substeps` steps per sample.

    Returns the twists x, x' and x'' (3, n, f). K and C (n, f, f) contain stiffness and damping of the springs.

    beta: 1/12 (Fox-Goodwin) has the smallest period error; 1/4 (average acceleration) is stable for any step.
    The arms start in static equilibrium, at the beginning and after each gap; NaN where the `torque` (n, f) is NaN.
    """
    n, count = torque.shape
    twists = np.full((3, n, count), np.nan)
    x, speed, acceleration = np.zeros(count), np.zeros(count), np.zeros(count)
    matrix, vector = np.zeros((count, count)), np.zeros(count)
    h, running = dt / substeps, False
    for k in range(n):
        if np.isnan(torque[k]).any():
            running = False
            continue
        if not running:
            matrix[:], x[:], speed[:], acceleration[:] = K[k], torque[k], 0.0, 0.0
            solve(matrix, x, count)
            running = True
        else:
            for substep in range(1, substeps + 1):
                past = 1 - substep / substeps
                for s in range(count):
                    x[s] += h * speed[s] + h * h * (0.5 - beta) * acceleration[s]
                    speed[s] += h / 2 * acceleration[s]
                for s in range(count):
                    vector[s] = torque[k, s] + past * (torque[k - 1, s] - torque[k, s])
                    for m in range(count):
                        stiffness = K[k, s, m] + past * (K[k - 1, s, m] - K[k, s, m])
                        damping = C[k, s, m] + past * (C[k - 1, s, m] - C[k, s, m])
                        inertia = M[k, s, m] + past * (M[k - 1, s, m] - M[k, s, m])
                        vector[s] -= stiffness * x[m] + damping * speed[m]
                        matrix[s, m] = inertia + h / 2 * damping + h * h * beta * stiffness
                solve(matrix, vector, count)
                for s in range(count):
                    x[s] += h * h * beta * vector[s]
                    speed[s] += h / 2 * vector[s]
                    acceleration[s] = vector[s]
        for s in range(count):
            twists[0, k, s], twists[1, k, s], twists[2, k, s] = x[s], speed[s], acceleration[s]
    return twists
