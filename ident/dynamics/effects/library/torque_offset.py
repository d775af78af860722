"""Constant torque; equivalent to Coulomb friction that differs between the directions."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """One everywhere (n, dof, 1)."""
    ones: Floats = np.where(np.isfinite(inputs.motion.velocity), 1.0, np.nan)[:, :, None]
    return ones


effect = Additive(
    sentence="The drive must give a constant torque, whatever the joint does.",
    symptom="The residual is shifted up or down by the same amount everywhere.",
    causes="an amplifier's zero, a cable's pull, a spring, or dry friction that differs between the directions",
    remedy="zero the amplifier's current or torque measurement, relieve the cables, record both directions equally",
    equation="a",
    axis="velocity",
    coefficients=(Quantity(name="a", unit="{effort}", meaning="the constant torque"),),
    columns=columns,
    c=CCode(expression="a"),
)
