"""Friction proportional to the torque that the gear transmits."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """|torque of the rigid model, with the effects on its arms| sgn v (n, dof, 1)."""
    lost: Floats = (np.abs(inputs.load) * inputs.motion.direction)[:, :, None]
    return lost


effect = Additive(
    sentence="The gear loses a share of the torque that it passes on: friction grows with the load.",
    symptom="The residual opposes the motion, and is the larger the harder the joint works.",
    causes="sliding teeth (worm, hypoid or planetary gears), bearings under load, too little lubricant",
    remedy="lubricate, check the gear's efficiency; add the loss to the feed-forward",
    equation="a |torque of the rigid model| sgn v, a >= 0",
    axis="load",
    coefficients=(Quantity(name="a", unit="1", meaning="share of the torque that is lost", lower=0.0, upper=1.0),),
    columns=columns,
    c=CCode(expression="a * fabs(load) * direction"),
)
