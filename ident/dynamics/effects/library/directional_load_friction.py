"""Friction proportional to the torque that the gear transmits, with another share in each direction of the power."""

from typing import Any

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity


def friction(load: Any, direction: Any) -> Any:
    """|load| sgn v where the motor drives the load, and where the load drives the motor.

    One half of |load| sgn v + load, and of the difference, so that a sample with a reversal counts in both.
    """
    lost = np.abs(load) * direction
    return (lost + load) / 2, (lost - load) / 2


effect = Additive(
    sentence="The gear loses one share of the torque where the motor drives the load, another where it is driven.",
    size="{a_d:%} and {a_b:%} of the load",
    symptom="The residual opposes motion and grows with the load, more where the motor lifts than where it brakes.",
    causes="gears with a large ratio (worm, cycloid, planetary), whose teeth carry more where the motor drives",
    remedy="lubricate, check the gear's efficiency in both directions; add the loss to the feed-forward",
    record="lifting and lowering at the same speeds, with at least two payloads",
    equation="a |torque of the rigid model| sgn v, a = a_d where the torque has the sign of v, else a_b, both >= 0",
    axis="load",
    contains=("load_dependent_friction",),
    mechanisms=("delta", "urdf"),  # on a single axis, half the difference of the shares is inertia and weight
    formula=friction,
    parameters=(
        Quantity(name="a_d", unit="1", meaning="share that is lost where the motor drives", lower=0.0, upper=1.0),
        Quantity(name="a_b", unit="1", meaning="share that is lost where the load drives", lower=0.0, upper=1.0),
    ),
)
