"""Friction that grows with the square of the speed."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """v |v| (n, dof, 1)."""
    velocity = inputs.motion.velocity
    square: Floats = (velocity * np.abs(velocity))[:, :, None]
    return square


effect = Additive(
    sentence="Beyond viscous friction, drag grows with the square of the joint's speed.",
    symptom="The residual bends away over the velocity, to opposite sides in the two directions.",
    causes="oil that is churned, a fan or turbulent air in the motor, a gear that runs full of grease",
    remedy="check the amount of oil or grease; add the term to the feed-forward",
    equation="a v |v|, a >= 0",
    axis="velocity",
    coefficients=(
        Quantity(name="a", unit="{effort} s^2/{position}^2", meaning="torque per squared speed", lower=0.0),
    ),
    columns=columns,
    c=CCode(expression="a * qd * fabs(qd)"),
)
