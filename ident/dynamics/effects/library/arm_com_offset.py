"""Offset of an arm's centre of mass from the line from shoulder to elbow."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The arm's centre of mass does not lie on the line from shoulder to elbow.",
    size="{a}",
    symptom="The residual follows the sine of the joint's angle, standing or moving.",
    causes="a motor, valve or cable bracket mounted on one side of the arm",
    remedy="measure or balance the arm; add the term to the gravity compensation",
    record="each joint slowly over its whole travel, in both directions",
    axis="position",
    mechanisms=("delta",),
    formula=lambda q: np.sin(q),
    parameters=(Quantity(name="a", unit="{effort}", meaning="weight times distance from the line"),),
    on_arm=True,
    bodies=("sine",),
)
