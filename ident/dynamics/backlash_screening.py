"""A first look at play, compiled as this is imported: each joint by itself, with all else left as it is."""

import math

import numpy as np

from ident.numba_cache import compiled
from recordings.recording import Floats


def _flights(load: Floats, tilt: Floats, inertia: Floats, half: float, dt: float, parts: int) -> Floats:
    """Torque (n,) that one arm takes because of play beyond what its side of the gap asks for, `parts` steps to an
    instant.

    load: (n,) in the middle of the gap, that changes by tilt (n,) per angle by which the motor is ahead;
    inertia: (n,) [kg m^2].
    """
    n = len(load)
    more = np.zeros(n)
    h, running, free = dt / parts, False, False
    x = w = 0.0
    for k in range(n):
        if not (math.isfinite(load[k]) and math.isfinite(tilt[k]) and math.isfinite(inertia[k])):
            running = False
            continue
        if not running:
            x, w, free, running = math.copysign(half, load[k]), 0.0, False, True
            continue
        if not free and (load[k] + tilt[k] * x) * x >= 0 and (load[k - 1] + tilt[k - 1] * x) * x >= 0:
            continue
        for part in range(1, parts + 1):
            need = load[k - 1] + (load[k] - load[k - 1]) * part / parts + tilt[k] * x
            free = free or need * x < 0
            if not free:
                continue
            more[k] -= need / parts
            w += h * need / inertia[k]
            x += h * w
            if abs(x) >= half:
                more[k] += inertia[k] * w / dt
                x, w, free = math.copysign(half, x), 0.0, False
    return more


def _falls(
    load: Floats,
    tilt: Floats,
    inertia: Floats,
    push: Floats,
    own: Floats,
    residual: Floats,
    shares: Floats,
    halves: Floats,
    dt: float,
    parts: int,
) -> Floats:
    """(s, h, dof) fall of the sum of squares of the `residual` (n, dof) by play.

    load, tilt, inertia: (n, dof) as `_flights`, of arms and motors; push (n, dof), own (dof,): torque and inertia
    of a joint by itself, of which the motors have `shares` (s,); `halves` (h,) of the play.
    """
    n, dof = load.shape
    fall = np.zeros((len(shares), len(halves), dof))
    for j in range(dof):
        for s in range(len(shares)):
            arm = load[:, j] - shares[s] * push[:, j]
            turned = np.maximum(inertia[:, j] - shares[s] * own[j], 0.01 * inertia[:, j])
            for h in range(len(halves)):
                more = flights(arm, tilt[:, j], turned, halves[h], dt, parts)
                together = size = 0.0
                for k in range(1, n - 1):
                    smooth = (more[k - 1] + 2 * more[k] + more[k + 1]) / 4
                    if smooth != 0.0 and math.isfinite(residual[k, j]):
                        together += smooth * residual[k, j]
                        size += smooth * smooth
                fall[s, h, j] = 2 * together - size
    return fall


flights = compiled(_flights)
falls = compiled(_falls)
