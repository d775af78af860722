"""Elasticity of the gear between the motor, which has the encoder, and the arm."""

from functools import partial

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.flexible_joints import change_of_torque, impossible
from recordings.recording import Floats

_SOFTEST = 0.02
"""Largest compliance [rad/(N m)]."""
_LIGHTEST = 1e-6
"""Smallest inertia of an arm on a spring from which a search starts [kg m^2]."""
_FILTER_ABOVE = 1.5
"""Natural frequency, as a multiple of the analysis bandwidth, above which the motion is fully low-passed: there, the
spring would amplify nothing but noise."""
_STIFFEST_GUESS, _SOFTEST_GUESS = 1e-4, 4e-3
"""Compliances [rad/(N m)] between which a search starts where no `guess_scale` is needed."""
_HIGHEST_GUESS = 40.0
"""Natural frequency [Hz] of a joint of a tree of links with that compliance, as scaled."""


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Compute the motor torque (n, dof), given `torque` of stiff joints, if springs connect motors and arms.

    The springs pass it on: damping x' + stiffness x = torque of the moving arms, with the twist x = motor angle - arm
    angle.
    """
    share, damping_ratio, compliance = float(values["motor"][0]), float(values["damping"][0]), values["compliance"]
    if not (compliance > 0).any():
        return torque
    return torque + inputs.remembered(
        ("joint_elasticity", share, damping_ratio, compliance.tobytes()),
        lambda: _change(inputs, share, damping_ratio, compliance),
    )


def _change(inputs: EffectInputs, share: float, damping_ratio: float, compliance: Floats) -> Floats:
    """Torque (n, dof) that springs add to that of stiff joints; 0 where it is unknown."""
    simulated = partial(_simulated, share=share, damping_ratio=damping_ratio, compliance=compliance)
    if inputs.rig.mechanism == "urdf":
        return inputs.coarsely(simulated)
    slowest = inputs.flexible_joints(share).natural_frequencies(inputs.motion, compliance).min(initial=np.inf) / (
        2 * np.pi * inputs.bandwidth
    )
    return simulated(inputs.low_passed(float(np.clip((slowest - 1) / (_FILTER_ABOVE - 1), 0.0, 1.0))))


def _simulated(inputs: EffectInputs, share: float, damping_ratio: float, compliance: Floats) -> Floats:
    elastic = inputs.flexible_joints(share).elastic_torque(inputs.motion, compliance, damping_ratio)
    return change_of_torque(elastic, inputs.arm_torque(share))


def guess_scale(inputs: EffectInputs) -> Floats:
    """Scale compliances (dof,) so that joints of a tree of links have equal natural frequencies."""
    inertia = inputs.motor_inertia(1.0)
    if inputs.rig.mechanism != "urdf":
        return np.ones_like(inertia)
    # Rounded: what is simulated beside one model serves beside the next, whose inertia differs by little.
    stiffness = 2 ** np.round(np.log2(np.maximum(inertia, _LIGHTEST) * (2 * np.pi * _HIGHEST_GUESS) ** 2))
    return np.minimum(1 / stiffness, _SOFTEST * _STIFFEST_GUESS / _SOFTEST_GUESS) / _STIFFEST_GUESS


effect = Signal(
    sentence="Between motor and arm something gives way: under load the arm lags behind the encoder.",
    size="{compliance}",
    symptom="The residual follows fast changes of the torque, like a mass that swings on a spring.",
    causes="a gear with a soft flexspline, a belt, a long shaft or coupling, a clamping that has come loose",
    remedy="check couplings and clamps; use smoother motion, or a controller that knows the spring",
    record="sharp accelerations, or a sweep of frequencies up to the resonance, at 1 kHz or more",
    equation="arm angle = motor angle - compliance * torque of the arm; the motor's inertia is on the encoder's side",
    axis="acceleration",
    impossible=impossible,
    memory=True,
    parameters=(
        Quantity(
            name="compliance",
            unit="{position}/({effort})",
            meaning="1 / stiffness",
            lower=0.0,
            upper=_SOFTEST,
            initial_guesses=(_STIFFEST_GUESS, 6e-4, _SOFTEST_GUESS),
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
        Quantity(
            name="damping",
            unit="1",
            meaning="of the spring, over the critical one",
            lower=0.0,
            upper=0.4,  # beyond, a spring would explain any lag
            initial_guesses=(0.05, 0.2),
            implausible_bound="upper",
        ),
    ),
    report=report,
    offset=True,
    guess_scale=guess_scale,
)
