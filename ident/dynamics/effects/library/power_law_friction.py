"""Friction that grows with a power of the speed, in place of viscous friction."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """|v|^alpha sgn v (n, dof, 1)."""
    motion = inputs.motion
    power: Floats = (np.abs(motion.velocity) ** shapes["alpha"] * motion.direction)[:, :, None]
    return power


effect = Additive(
    sentence="Friction does not grow in proportion to the speed, but with a power of it.",
    symptom="Over the velocity the residual is bent, to opposite sides in the two directions, at all speeds.",
    causes="grease that gets thinner the faster it is sheared, rolling contacts, seals",
    remedy="nothing is broken; a feed-forward that follows the speed wants the power in place of the viscous term",
    equation="c |v|^alpha sgn v in place of c_v v, c >= 0",
    axis="velocity",
    contains=("quadratic_friction",),
    replaces="c_v",
    coefficients=(
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
    columns=columns,
    c=CCode(expression="c * pow(fabs(qd), alpha) * direction"),
)
