"""Backlash between a motor, which carries the encoder, and its arm."""

from dataclasses import dataclass

import numpy as np
from numba import njit

from recordings.recording import Floats

_TOOTH = 1500.0
"""Natural frequency of an arm on a tooth, which sets the tooth's stiffness [rad/s]; damping is critical."""
_OIL = 0.02
"""Viscous friction inside the gap [N m s/rad]."""
_STEP = 6e-5
"""Approximate step of the integration [s]."""


@dataclass(frozen=True, eq=False)
class Linear:
    """Linearized dynamics of the arms for small deviations d from the motors' motion: torque + M d'' + C d' + K d."""

    inertia: Floats
    """(m, 3, 3) M, at every `every`-th instant."""
    damping: Floats
    stiffness: Floats
    every: int


def backlash_torque(torque: Floats, linear: Linear, half: Floats, dt: float) -> Floats:
    """Torque (n, 3) on the teeth if the arms can lag or lead by `half` (3,) [rad].

    torque: torque that the arms need to follow the motors exactly (n, 3); dt: time between instants [s].
    """
    inverse = np.linalg.inv(linear.inertia).astype(np.float64)
    tooth = _TOOTH**2 * np.einsum("mii->i", linear.inertia) / len(inverse)
    substeps = max(round(dt / _STEP), 1)
    result: Floats = _integrate(
        torque, inverse, linear.damping, linear.stiffness, linear.every, half, tooth, dt / substeps, substeps
    )
    return result


@njit(cache=True)
def _tooth_torque(d: float, v: float, half: float, tooth: float) -> float:
    """Torque on an arm that leads by d [rad]; teeth push but never pull."""
    penetration, damping_torque = abs(d) - half, 2 * tooth / _TOOTH * v
    if penetration <= 0:
        return -_OIL * v
    return (
        max(tooth * penetration - damping_torque, 0.0) if d < 0 else min(-tooth * penetration - damping_torque, 0.0)
    )


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
    substeps: int,
) -> Floats:
    n = len(torque)
    result = np.empty((n, 3))
    d, v, tooth_torque, net_torque = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(3):
        d[i] = -np.sign(torque[0, i]) * half[i] - torque[0, i] / tooth[i]
    for k in range(n):
        m = min(k // every, len(inverse) - 1)
        mean_torque = np.zeros(3)
        for substep in range(substeps):
            share = substep / substeps
            next_torque = torque[min(k + 1, n - 1)]
            for i in range(3):
                tooth_torque[i] = _tooth_torque(d[i], v[i], half[i], tooth[i])
                net_torque[i] = tooth_torque[i] - (1 - share) * torque[k, i] - share * next_torque[i]
                for j in range(3):
                    net_torque[i] -= damping[m, i, j] * v[j] + stiffness[m, i, j] * d[j]
                mean_torque[i] += tooth_torque[i] / substeps
            for i in range(3):
                for j in range(3):
                    v[i] += dt * inverse[m, i, j] * net_torque[j]
            for i in range(3):
                d[i] += dt * v[i]
        result[k] = mean_torque
    return result
