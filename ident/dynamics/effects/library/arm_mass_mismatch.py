"""Difference of one arm's mass from that of the others."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="One arm is heavier or lighter than the others.",
    size="{a}",
    symptom="The residual of one joint follows the cosine of its angle, standing or moving.",
    causes="a repaired or reinforced arm, a cable harness that hangs on one arm only",
    remedy="weigh the arms; give each its own gravity torque",
    record="each joint slowly over its whole travel, in both directions",
    axis="position",
    mechanisms=("delta",),
    formula=lambda q: np.cos(q),
    parameters=(Quantity(name="a", unit="{effort}", meaning="gravity torque beyond that of the other arms"),),
    on_arm=True,
    differential=True,
    bodies=("cosine",),
)
