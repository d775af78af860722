"""Play in the gear."""

import numpy as np

from ident.compiled import compiled
from ident.effects import Quantity, Signal, Values
from ident.view import View
from recordings.recording import Floats


def report(torque: Floats, view: View, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms can move by +-b against them."""
    share = float(values["motor"][0])
    load = view.arm_torque(share)
    inertias = view.arm_inertias(share)
    inertia = np.ascontiguousarray(np.diagonal(inertias, axis1=1, axis2=2))
    half = np.broadcast_to(values["b"], (load.shape[1],)).astype(float)
    free, side = compiled(_along)(np.ascontiguousarray(load), inertia, half, 1 / view.rate)
    shift = view.weight_shift(-side)
    change = np.where(np.isfinite(shift), shift, 0.0)
    # What flies or is hit pushes the other joints, too.
    reactions = np.einsum("nji,ni->nj", inertias, np.where(inertia > 0, free / inertia, 0.0))
    reported: Floats = torque + change + np.where(np.isfinite(reactions), reactions, free)
    return reported


def _along(load: Floats, inertia: Floats, half: Floats, dt: float) -> tuple[Floats, Floats]:
    """Torque (n, dof) that the motors give beyond the `load`, and angle (n, dof) of the motors before the arms.

    load: torque that the arm would need (n, dof); inertia (n, dof) of what flies freely in the gap.
    In the gap the arm gets none; relative to the motor it then accelerates by -load / inertia, and the teeth hit
    without bounce: the motor gives the arm back its speed within one instant.
    """
    more, side = np.zeros(load.shape), np.zeros(load.shape)
    for joint in range(load.shape[1]):
        b = half[joint]
        if b <= 0.0:
            continue
        x, speed, started = 0.0, 0.0, False
        for k in range(load.shape[0]):
            need = load[k, joint]
            if np.isnan(need):
                started = False
                continue
            if not started:
                x, speed, started = (b if need > 0 else -b), 0.0, True
            pushed = (x >= b and need >= 0) or (x <= -b and need <= 0)
            if pushed:
                speed = 0.0
            else:
                mass = inertia[k, joint]
                speed += need / mass * dt
                x += speed * dt
                more[k, joint] = -need
                if abs(x) >= b:
                    more[k, joint] += mass * speed / dt
                    x = b if x > 0 else -b
                    speed = 0.0
            side[k, joint] = x
    return more, side


effect = Signal(
    sentence="There is play in the gear: when the load changes its side, the motor runs free for a moment.",
    looks="The residual has short peaks where the torque of the joint changes its sign, and steps beside them.",
    causes="worn teeth, a loose key or coupling, a gear without preload",
    remedy="set or replace the gear; avoid changes of load direction where precision matters",
    equation="arm free within +-b of the motor, where the encoder is; teeth hit without bounce",
    axis="load",
    parameters=(
        Quantity(
            name="b",
            unit="{position}",
            meaning="half of the play",
            lower=0.0,
            upper=0.05,
            starts=(5e-4, 2e-3, 8e-3, 0.025),
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
