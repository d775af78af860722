"""A gear that gives way, between the motor with the encoder and the arm."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from recordings.recording import Floats

_BEYOND = 1.5
"""Of arms that swing so many times faster than the bandwidth of the analysis, noise is all that would be seen."""


def report(torque: Floats, view: EffectInputs, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms hang on springs: the springs' torque.

    With the twist x = motor's angle - arm's angle, damping x' + stiffness x = torque of the arms as they then move.
    """
    share, ratio, compliance = float(values["motor"][0]), float(values["damping"][0]), values["compliance"]
    if not (compliance > 0).any():
        return torque
    arms = view.flexible_joints(share)
    slowest = arms.natural_frequencies(view.motion, compliance).min(initial=np.inf) / (2 * np.pi * view.bandwidth)
    view = view.low_passed(float(np.clip((slowest - 1) / (_BEYOND - 1), 0.0, 1.0)))
    changed = arms.elastic_torque(view.motion, compliance, ratio) - view.arm_torque(share)
    return torque + np.where(np.isfinite(changed), changed, 0.0)


effect = Signal(
    sentence="Between motor and arm something gives way: under load the arm lags behind the encoder.",
    symptom="The residual follows fast changes of the torque, like a mass that swings on a spring.",
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
            initial_guesses=(1e-4, 6e-4, 4e-3),
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
)
