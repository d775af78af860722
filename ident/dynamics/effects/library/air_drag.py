"""Air drag of the platform."""

from typing import Any

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity


def drag(J: Any, platform_velocity: Any) -> Any:
    """J' |P'| P'."""
    x, y, z = platform_velocity
    return np.sqrt(x * x + y * y + z * z) * (J[0] * x + J[1] * y + J[2] * z)


effect = Additive(
    sentence="The air brakes the platform and what it carries, with the square of its speed.",
    size="{c}",
    symptom="The residual opposes the platform's motion where it is fast, in all joints.",
    causes="a large flat gripper or load, a cover, a fan or extraction that blows against it",
    remedy="slow down large loads, or add the drag to the feed-forward",
    record="the platform as fast as it may go, with the large gripper or load on it, and once slowly",
    equation="J' c |P'| P', c >= 0",
    axis="velocity",
    mechanisms=("delta",),
    whole_robot=True,
    formula=drag,
    parameters=(Quantity(name="c", unit="N s^2/m^2", meaning="force per squared speed", lower=0.0),),
    on_arm=True,
)
