"""Dry friction that is higher around one angle."""

import numpy as np

from ident.effects import Additive, Quantity, Shapes
from ident.view import View
from recordings.recording import Floats


def columns(view: View, shapes: Shapes) -> Floats:
    """exp(-((q - q_0) / w)^2) sgn v (n, dof, 1)."""
    near = np.exp(-(((view.motion.position - shapes["q_0"]) / shapes["w"]) ** 2))
    return (near * view.motion.direction)[:, :, None]


effect = Additive(
    sentence="Around one angle the joint rubs harder.",
    symptom="The residual opposes the motion, at one angle only.",
    causes="a dent in a bearing, a cable that chafes",
    remedy="look at the joint at that angle",
    equation="a exp(-((q - q_0) / w)^2) sgn v, a >= 0",
    axis="position",
    coefficients=(Quantity(name="a", unit="{effort}", meaning="dry friction there", lower=0.0),),
    shapes=(
        Quantity(name="q_0", unit="{position}", meaning="where", starts=(-0.8, -0.6, -0.4, -0.2, 0.0, 0.2)),
        Quantity(name="w", unit="{position}", meaning="half its width", lower=0.01, upper=1.0, starts=(0.1,)),
    ),
    columns=columns,
)
