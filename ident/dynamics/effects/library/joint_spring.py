"""Spring torque at a joint."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="Something springy pulls the joint towards one angle.",
    size="{k}",
    symptom="The residual is a straight line over the joint's angle.",
    causes="a cable or hose that is bent, a balancing spring, a bellows or a stiff cover",
    remedy="lead cables so that they do not pull; if the spring is meant, add it to the feed-forward",
    record="the joint slowly over its whole travel, in both directions",
    equation="k q + a, k >= 0 (rest angle -a / k)",
    axis="position",
    usual_travel=4 * np.pi,  # what is tied to both parts does not turn for ever
    contains=("torque_offset",),
    formula=lambda q: (q, 1.0),
    parameters=(
        Quantity(name="k", unit="{effort}/{position}", meaning="stiffness", lower=0.0, reduces_to="torque_offset"),
        Quantity(name="a", unit="{effort}", meaning="torque at angle zero"),
    ),
    bodies=("stiffness", "torque_at_zero"),
)
