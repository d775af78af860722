"""Backlash of the gear."""

from functools import partial

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.flexible_joints import change_of_torque, impossible
from recordings.recording import Floats

_MOTOR_SHARES = np.linspace(0.0, 0.96, 49)
"""Grid of the motor's share of a joint's own inertia."""
_HALF_GAPS = np.geomspace(3e-5, 0.04, 61)
"""Grid of half the gap [rad or m]."""
_BEST = 4
"""Number of suggestions."""
_IMPACT_DELAY = 1.5e-4
"""Standard deviation of the instant of an impact [s]: teeth give way for up to a millisecond."""


def report(torque: Floats, inputs: EffectInputs, values: Values, impact_delay: float = 0.0) -> Floats:
    """Compute the motor torque (n, dof), given `torque` without backlash, if arms move by +-b against the motors.

    impact_delay: time from the contact to the middle of the impact [s].
    """
    share = float(values["motor"][0])
    half_gap = np.broadcast_to(values["b"], (torque.shape[1],)).astype(float)
    if not (half_gap > 0).any():
        return torque
    return torque + inputs.remembered(
        ("backlash", share, half_gap.tobytes(), impact_delay),
        lambda: _change(inputs, share, half_gap, impact_delay),
    )


def _change(inputs: EffectInputs, share: float, half_gap: Floats, impact_delay: float) -> Floats:
    """Torque (n, dof) that a gap adds; 0 where it is unknown."""
    simulated = partial(_simulated, share=share, half_gap=half_gap, impact_delay=impact_delay)
    return inputs.coarsely(simulated) if inputs.rig.mechanism == "urdf" else simulated(inputs.low_passed())


def _simulated(inputs: EffectInputs, share: float, half_gap: Floats, impact_delay: float) -> Floats:
    with_gap = inputs.flexible_joints(share).backlash_torque(inputs.motion, half_gap, impact_delay)
    return change_of_torque(with_gap, inputs.arm_torque(share))


def suggest(inputs: EffectInputs, residual: Floats) -> list[dict[str, Floats]]:
    """Suggest the best motor shares of a grid, each with the best gap of every joint.

    The motor share determines when the load of the gear changes its sign, and so when the teeth separate. The cost
    has many local minima over it.
    """
    joint_inertia = inputs.motor_inertia(1.0)
    every = 2 if inputs.rig.mechanism == "urdf" else 1  # twice the joints
    shares, gaps = _MOTOR_SHARES[::every], _HALF_GAPS[::every]
    reductions = inputs.flexible_joints(0.0).cost_reductions(inputs.motion, joint_inertia, residual, shares, gaps)
    total = np.maximum(reductions.max(axis=1), 0.0).sum(axis=1)
    padded = np.pad(total, 1)
    peaks = np.flatnonzero((total > 0) & (total >= padded[:-2]) & (total >= padded[2:]))
    best = sorted(peaks, key=lambda s: -total[s])[:_BEST]
    return [{"b": gaps[reductions[s].argmax(axis=0)], "motor": shares[s]} for s in best]


effect = Signal(
    sentence="There is play in the gear: when the load changes its side, the motor runs free for a moment.",
    size="± {b}",
    symptom="The residual has short peaks where the torque of the joint changes its sign, and steps beside them.",
    causes="worn teeth, a loose key or coupling, a gear without preload",
    remedy="set or replace the gear; avoid changes of load direction where precision matters",
    record="slow motion in which the torque changes its sign, without an offset of weight where possible",
    equation="arm free within +-b of the motor, where the encoder is; teeth hit without bounce",
    axis="load",
    impossible=impossible,
    memory=True,
    step=1e-2,
    discontinuous=True,
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
    perturbed_report=partial(report, impact_delay=_IMPACT_DELAY),
    offset=True,
    suggest=suggest,
)
