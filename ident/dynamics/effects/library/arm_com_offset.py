"""Offset of an arm's centre of mass from the line from shoulder to elbow."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """sin q (n, dof, 1)."""
    sine: Floats = np.sin(inputs.motion.position)[:, :, None]
    return sine


effect = Additive(
    sentence="The arm's centre of mass does not lie on the line from shoulder to elbow.",
    symptom="The residual follows the sine of the joint's angle, standing or moving.",
    causes="a motor, valve or cable bracket mounted on one side of the arm",
    remedy="measure or balance the arm; add the term to the gravity compensation",
    equation="a sin q",
    axis="position",
    mechanisms=("delta",),
    coefficients=(Quantity(name="a", unit="{effort}", meaning="weight times distance from the line"),),
    columns=columns,
    on_arm=True,
    c=CCode(expression="a * sin(q)"),
)
