"""A gear that gives way, between the motor with the encoder and the arm."""

import numpy as np

from ident.compiled import compiled
from ident.effects import Quantity, Signal, Values
from ident.view import View
from recordings.recording import Floats, Ints

_DAMPING = 0.03
"""Of the spring, over the critical one."""


def report(torque: Floats, view: View, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms hang on springs: the springs' torque.

    With the twist x = motor's angle - arm's angle, inertia x'' + damping x' + stiffness x = torque that the arms
    would need to follow the motors.
    """
    share, compliance = float(values["motor"][0]), values["compliance"]
    soft = np.flatnonzero(compliance > 0)
    if not len(soft):
        return torque
    rigid = view.arm_torque(share)
    inertias = np.ascontiguousarray(view.arm_inertias(share)[:, :, soft])
    sag = np.zeros_like(rigid)
    sag[:, soft] = rigid[:, soft] * compliance[soft]
    load = rigid + view.weight_shift(-sag)  # the arms' weight is that of the place where they are
    acceleration = compiled(_swings)(
        np.ascontiguousarray(load[:, soft]), inertias, soft, compliance[soft], 1 / view.rate
    )
    changed = load - np.einsum("njs,ns->nj", inertias, acceleration) - rigid
    return torque + np.where(np.isfinite(changed), changed, 0.0)


def _swings(  # noqa: C901 - compiled: one loop
    load: Floats, inertias: Floats, soft: Ints, compliance: Floats, dt: float
) -> Floats:
    """Acceleration (n, s) of the twist of the s soft joints, by Newmark's method with mean acceleration.

    load (n, s); inertias (n, dof, s) of the arms; soft (s,) which joints these are; compliance (s,). It starts
    without swinging; NaN where the load is.
    """
    n, count = load.shape
    stiffness = 1 / compliance
    acceleration = np.full((n, count), np.nan)
    x, v, a = np.zeros(count), np.zeros(count), np.zeros(count)
    matrix, right = np.zeros((count, count)), np.zeros(count)
    running = False
    for k in range(n):
        if np.isnan(load[k]).any() or np.isnan(inertias[k]).any():
            running = False
            continue
        if running:
            for i in range(count):
                damping = 2 * _DAMPING * np.sqrt(stiffness[i] * inertias[k, soft[i], i])
                right[i] = load[k, i] - damping * (v[i] + dt / 2 * a[i])
                right[i] -= stiffness[i] * (x[i] + dt * v[i] + dt * dt / 4 * a[i])
                for j in range(count):
                    matrix[i, j] = inertias[k, soft[i], j]
                matrix[i, i] += dt / 2 * damping + dt * dt / 4 * stiffness[i]
            for i in range(count):  # elimination; the matrix is positive definite
                for j in range(i + 1, count):
                    part = matrix[j, i] / matrix[i, i]
                    right[j] -= part * right[i]
                    for m in range(i, count):
                        matrix[j, m] -= part * matrix[i, m]
            for i in range(count - 1, -1, -1):
                for j in range(i + 1, count):
                    right[i] -= matrix[i, j] * right[j]
                right[i] /= matrix[i, i]
            for i in range(count):
                x[i] += dt * v[i] + dt * dt / 4 * (a[i] + right[i])
                v[i] += dt / 2 * (a[i] + right[i])
                a[i] = right[i]
        else:
            for i in range(count):
                x[i], v[i], a[i] = load[k, i] * compliance[i], 0.0, 0.0
            running = True
        acceleration[k] = a
    return acceleration


effect = Signal(
    sentence="Between motor and arm something gives way: under load the arm lags behind the encoder.",
    looks="The residual follows fast changes of the torque, like a mass that swings on a spring.",
    causes="a gear with a soft flexspline, a belt, a long shaft or coupling, a clamping that has come loose",
    remedy="check couplings and clamps; use smoother motion, or a controller that knows the spring",
    equation="arm angle = motor angle - compliance * torque of the arm; the motor's inertia is on the encoder's side",
    axis="acceleration",
    parameters=(
        Quantity(
            name="compliance",
            unit="{position}/({effort})",
            meaning="1 / stiffness",
            lower=0.0,
            upper=0.02,
            starts=(2e-4, 1e-3, 4e-3),
        ),
    ),
    shapes=(
        Quantity(
            name="motor",
            unit="1",
            meaning="the motor's share of a joint's own inertia",
            lower=0.0,
            upper=0.98,
            starts=(0.3, 0.7),
        ),
    ),
    report=report,
)
