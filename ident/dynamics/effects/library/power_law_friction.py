"""Friction that grows with a power of the speed, in place of viscous friction."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="Friction does not grow in proportion to the speed, but with a power of it.",
    size="{c}, power {alpha:n}",
    symptom="Over the velocity the residual is bent, to opposite sides in the two directions, at all speeds.",
    causes="grease that gets thinner the faster it is sheared, rolling contacts, seals",
    remedy="nothing is broken; a feed-forward that follows the speed wants the power in place of the viscous term",
    record="strokes at constant speeds over a wide range, ten to one or more, in both directions",
    axis="velocity",
    contains=("quadratic_friction",),
    replaces="c_v",
    formula=lambda qd, direction, alpha: np.abs(qd) ** alpha * direction,
    parameters=(
        Quantity(name="c", unit="{effort} (s/{position})^alpha", meaning="friction at unit speed", lower=0.0),
    ),
    shapes=(
        Quantity(
            name="alpha",
            unit="1",
            meaning="power of the speed; 1 is viscous friction",
            lower=0.2,
            upper=2.0,
            initial_guesses=(0.3, 0.55, 0.8, 1.5),
            implausible_bound="lower",  # hardly grows with the speed: Coulomb friction, or none of this
        ),
    ),
)
