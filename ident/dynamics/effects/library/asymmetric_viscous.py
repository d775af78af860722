"""Viscous friction whose coefficient differs by direction."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """|v| (n, dof, 1)."""
    size: Floats = np.abs(inputs.motion.velocity)[:, :, None]
    return size


effect = Additive(
    sentence="The joint is dragged harder in one direction than in the other, the more the faster it moves.",
    symptom="The residual is a V over the velocity: it rises to both sides of standstill.",
    causes="a gear or a seal that is not the same in both directions, a pump or fan that the joint drives",
    remedy="check the gear's preload and the seals; give the feed-forward a coefficient for each direction",
    equation="a |v|",
    axis="velocity",
    coefficients=(
        Quantity(name="a", unit="{effort} s/{position}", meaning="half the difference of the viscous coefficients"),
    ),
    columns=columns,
    c=CCode(expression="a * fabs(qd)"),
)
