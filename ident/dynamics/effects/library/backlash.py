"""Play in the gear."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from recordings.recording import Floats

_SHARES = np.linspace(0.0, 0.96, 49)
"""Of the motors in a joint's own inertia, that are tried."""
_HALVES = np.geomspace(3e-5, 0.04, 61)
"""Of the gap, that are tried [rad or m]."""
_BEST = 4


def report(torque: Floats, view: EffectInputs, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms can move by +-b against them."""
    share = float(values["motor"][0])
    half = np.broadcast_to(values["b"], (torque.shape[1],)).astype(float)
    if not (half > 0).any():
        return torque
    view = view.low_passed()
    changed = view.flexible_joints(share).backlash_torque(view.motion, half) - view.arm_torque(share)
    return torque + np.where(np.isfinite(changed), changed, 0.0)


def suggest(view: EffectInputs, residual: Floats) -> list[dict[str, Floats]]:
    """The best of many shares of the motors' inertia, each with the best width of every joint's gap.

    When the load of the gear changes its side, and so when the arm flies, depends on that share: the landscape is
    full of valleys.
    """
    own = view.motor_inertia(1.0)
    falls = view.flexible_joints(0.0).cost_reductions(view.motion, own, residual, _SHARES, _HALVES)
    fall = np.maximum(falls.max(axis=1), 0.0).sum(axis=1)
    around = np.pad(fall, 1)
    peaks = np.flatnonzero((fall > 0) & (fall >= around[:-2]) & (fall >= around[2:]))
    best = sorted(peaks, key=lambda s: -fall[s])[:_BEST]
    return [{"b": _HALVES[falls[s].argmax(axis=0)], "motor": _SHARES[s]} for s in best]


effect = Signal(
    sentence="There is play in the gear: when the load changes its side, the motor runs free for a moment.",
    symptom="The residual has short peaks where the torque of the joint changes its sign, and steps beside them.",
    causes="worn teeth, a loose key or coupling, a gear without preload",
    remedy="set or replace the gear; avoid changes of load direction where precision matters",
    equation="arm free within +-b of the motor, where the encoder is; teeth hit without bounce",
    axis="load",
    step=1e-2,
    multistart=_BEST,
    parameters=(
        Quantity(
            name="b",
            unit="{position}",
            meaning="half of the play",
            lower=0.0,
            upper=0.05,
            initial_guesses=(5e-4, 8e-3),
        ),
    ),
    shapes=(
        Quantity(
            name="motor",
            unit="1",
            meaning="the motor's share of a joint's own inertia",
            lower=0.0,
            upper=0.98,
            initial_guesses=(0.3, 0.7),
            implausible_bound="upper",
        ),
    ),
    report=report,
    suggest=suggest,
)
