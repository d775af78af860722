"""Viscous friction whose coefficient differs by direction."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The joint is dragged harder in one direction than in the other, the more the faster it moves.",
    size="{a}",
    symptom="The residual is a V over the velocity: it rises to both sides of standstill.",
    causes="a gear or a seal that is not the same in both directions, a pump or fan that the joint drives",
    remedy="check the gear's preload and the seals; give the feed-forward a coefficient for each direction",
    record="strokes of the same speed in both directions, at several speeds",
    axis="velocity",
    formula=lambda qd: np.abs(qd),
    parameters=(
        Quantity(name="a", unit="{effort} s/{position}", meaning="half the difference of the viscous coefficients"),
    ),
)
