"""What stands between a motor, where the encoder sits, and its arm: play."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from recordings.recording import Floats

_TOOTH = 1500.0
"""A tooth is so stiff that an arm on it would swing at this rate [rad/s]; it is damped critically."""
_OIL = 0.02
"""Drag inside the gap [N m s/rad]."""
_STEP = 6e-5
"""About the step of the integration [s]."""


@dataclass(frozen=True, eq=False)
class Linear:
    """The arms' dynamics for small deviations d from the motors' motion: torque + M d'' + C d' + K d."""

    inertia: Floats
    """(m, 3, 3) M, at every `every`-th instant."""
    damping: Floats
    stiffness: Floats
    every: int


def play(torque: Floats, linear: Linear, half: Floats, dt: float) -> Floats:
    """Torque (n, 3) on the teeth where the arms may lag or lead by `half` (3,) [rad].

    torque: what the arms need to follow the motors exactly (n, 3); dt: between instants [s].
    """
    inverse = np.linalg.inv(linear.inertia).astype(np.float64)
    tooth = _TOOTH**2 * np.einsum("mii->i", linear.inertia) / len(inverse)
    parts = max(round(dt / _STEP), 1)
    result: Floats = _integrate(
        torque, inverse, linear.damping, linear.stiffness, linear.every, half, tooth, dt / parts, parts
    )
    return result


@njit(cache=True)
def _push(d: float, v: float, half: float, tooth: float) -> float:
    """Torque on an arm that is ahead by d [rad]; teeth push and never pull."""
    beyond, drag = abs(d) - half, 2 * tooth / _TOOTH * v
    if beyond <= 0:
        return -_OIL * v
    return max(tooth * beyond - drag, 0.0) if d < 0 else min(-tooth * beyond - drag, 0.0)


@njit(cache=True)
def _integrate(
    torque: Floats,
    inverse: Floats,
    damping: Floats,
    stiffness: Floats,
    every: int,
    half: Floats,
    tooth: Floats,
    dt: float,
    parts: int,
) -> Floats:
    n = len(torque)
    result = np.empty((n, 3))
    d, v, force, need = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(3):
        d[i] = -np.sign(torque[0, i]) * half[i] - torque[0, i] / tooth[i]
    for k in range(n):
        m = min(k // every, len(inverse) - 1)
        mean = np.zeros(3)
        for part in range(parts):
            share = part / parts
            after = torque[min(k + 1, n - 1)]
            for i in range(3):
                force[i] = _push(d[i], v[i], half[i], tooth[i])
                need[i] = force[i] - (1 - share) * torque[k, i] - share * after[i]
                for j in range(3):
                    need[i] -= damping[m, i, j] * v[j] + stiffness[m, i, j] * d[j]
                mean[i] += force[i] / parts
            for i in range(3):
                for j in range(3):
                    v[i] += dt * inverse[m, i, j] * need[j]
            for i in range(3):
                d[i] += dt * v[i]
        result[k] = mean
    return result
