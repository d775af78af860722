"""Air drag of the platform."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """J' |P'| P' (n, dof, 1)."""
    velocity = inputs.platform.velocity
    force = np.linalg.norm(velocity, axis=1)[:, None] * velocity
    drag: Floats = np.einsum("nij,ni->nj", inputs.platform.jacobian, force)[:, :, None]
    return drag


effect = Additive(
    sentence="The air brakes the platform and what it carries, with the square of its speed.",
    symptom="The residual opposes the platform's motion where it is fast, in all joints.",
    causes="a large flat gripper or load, a cover, a fan or extraction that blows against it",
    remedy="slow down large loads, or add the drag to the feed-forward",
    equation="J' c |P'| P', c >= 0",
    axis="velocity",
    mechanisms=("delta",),
    whole_robot=True,
    coefficients=(Quantity(name="c", unit="N s^2/m^2", meaning="force per squared speed", lower=0.0),),
    columns=columns,
    on_arm=True,
    c=CCode(
        statements="const real speed = sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] "
        "+ velocity[2] * velocity[2]);",
        expression="c * speed * (J[i][0] * velocity[0] + J[i][1] * velocity[1] + J[i][2] * velocity[2])",
    ),
)
