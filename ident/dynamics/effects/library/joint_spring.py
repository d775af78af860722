"""Spring torque at a joint."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """The angle and one (n, dof, 2)."""
    position = inputs.motion.position
    pair: Floats = np.stack([position, np.where(np.isfinite(position), 1.0, np.nan)], axis=2)
    return pair


effect = Additive(
    sentence="Something springy pulls the joint towards one angle.",
    symptom="The residual is a straight line over the joint's angle.",
    causes="a cable or hose that is bent, a balancing spring, a bellows or a stiff cover",
    remedy="lead cables so that they do not pull; if the spring is meant, add it to the feed-forward",
    equation="k q + a, k >= 0 (rest angle -a / k)",
    axis="position",
    contains=("torque_offset",),
    coefficients=(
        Quantity(name="k", unit="{effort}/{position}", meaning="stiffness", lower=0.0, reduces_to="torque_offset"),
        Quantity(name="a", unit="{effort}", meaning="torque at angle zero"),
    ),
    columns=columns,
    c=CCode(expression="k * q + a"),
)
