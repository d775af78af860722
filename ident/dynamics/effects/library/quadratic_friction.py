"""Friction that grows with the square of the speed."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="Beyond viscous friction, drag grows with the square of the joint's speed.",
    size="{a}",
    symptom="The residual bends away over the velocity, to opposite sides in the two directions.",
    causes="oil that is churned, a fan or turbulent air in the motor, a gear that runs full of grease",
    remedy="check the amount of oil or grease; add the term to the feed-forward",
    record="strokes at constant speeds up to the highest, in both directions",
    axis="velocity",
    formula=lambda qd: qd * np.abs(qd),
    parameters=(Quantity(name="a", unit="{effort} s^2/{position}^2", meaning="torque per squared speed", lower=0.0),),
)
