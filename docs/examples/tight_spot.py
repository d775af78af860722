"""Dry friction that is higher around one angle."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="Around one angle the joint rubs harder.",
    size="{a} at {q_0}",
    symptom="The residual opposes the motion, at one angle only.",
    causes="a dent in a bearing, a cable that chafes",
    remedy="look at the joint at that angle",
    axis="position",
    formula=lambda q, direction, q_0, w: np.exp(-(((q - q_0) / w) ** 2)) * direction,
    parameters=(Quantity(name="a", unit="{effort}", meaning="dry friction there", lower=0.0),),
    shapes=(
        Quantity(name="q_0", unit="{position}", meaning="where", initial_guesses=(-0.8, -0.6, -0.4, -0.2, 0.0, 0.2)),
        Quantity(
            name="w", unit="{position}", meaning="half its width", lower=0.01, upper=1.0, initial_guesses=(0.1,)
        ),
    ),
)
