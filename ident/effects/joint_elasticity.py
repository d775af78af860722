"""A gear that gives way, between the motor with the encoder and the arm."""

import numpy as np

from ident.compiled import compiled
from ident.effects import Quantity, Signal, Values
from ident.view import View
from recordings.recording import Floats

_RIGID = 1e-7
"""Compliance of a joint that does not give way, or next to nothing [rad/(N m)]."""
_DAMPING = 0.03
"""Of the spring, over the critical one."""


def report(torque: Floats, view: View, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms hang on springs: the springs' torque.

    With the twist x = motor's angle - arm's angle, inertia x'' + damping x' + stiffness x = torque that the arms
    would need to follow the motors.
    """
    share = float(values["motor"][0])
    load = view.arm_torque(view.motion, share)
    compliance = np.maximum(np.broadcast_to(values["compliance"], (load.shape[1],)), _RIGID)
    inertias = view.arm_inertias(share)
    springs = compiled(_springs)(np.ascontiguousarray(load), inertias, 1 / compliance, _DAMPING, 1 / view.rate)
    return torque + np.where(values["compliance"] > _RIGID, springs - load, 0.0)


def _springs(load: Floats, inertia: Floats, stiffness: Floats, ratio: float, dt: float) -> Floats:
    """Torque (n, dof) of the springs, by Newmark's method with mean acceleration; NaN where there is no load.

    load (n, dof); inertia (n, dof, dof) of the arms; stiffness (dof,); damping ratio. It starts without swinging.
    """
    n, dof = load.shape
    result = np.full((n, dof), np.nan)
    x, v, a = np.zeros(dof), np.zeros(dof), np.zeros(dof)
    running = False
    for k in range(n):
        if np.isnan(load[k]).any() or np.isnan(inertia[k]).any():
            running = False
            continue
        mass = inertia[k]
        damping = np.zeros(dof)
        for j in range(dof):
            damping[j] = 2 * ratio * np.sqrt(stiffness[j] * mass[j, j])
        if not running:
            x, v, a = load[k] / stiffness, np.zeros(dof), np.zeros(dof)
            running = True
        else:
            ahead = x + dt * v + dt * dt / 4 * a
            faster = v + dt / 2 * a
            matrix = mass + np.diag(dt / 2 * damping + dt * dt / 4 * stiffness)
            a = np.linalg.solve(matrix, load[k] - damping * faster - stiffness * ahead)
            x = ahead + dt * dt / 4 * a
            v = faster + dt / 2 * a
        result[k] = stiffness * x
    return result


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
