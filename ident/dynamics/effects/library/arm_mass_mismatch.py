"""Difference of one arm's mass from that of the others."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """cos q (n, dof, 1)."""
    cosine: Floats = np.cos(inputs.motion.position)[:, :, None]
    return cosine


effect = Additive(
    sentence="One arm is heavier or lighter than the others.",
    symptom="The residual of one joint follows the cosine of its angle, standing or moving.",
    causes="a repaired or reinforced arm, a cable harness that hangs on one arm only",
    remedy="weigh the arms; give each its own gravity torque",
    equation="a cos q",
    axis="position",
    mechanisms=("delta",),
    coefficients=(Quantity(name="a", unit="{effort}", meaning="gravity torque beyond that of the other arms"),),
    columns=columns,
    on_arm=True,
    differential=True,
    c=CCode(expression="a * cos(q)"),
)
