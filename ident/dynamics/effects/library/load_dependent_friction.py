"""Friction proportional to the torque that the gear transmits."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The gear loses a share of the torque that it passes on: friction grows with the load.",
    size="{a:%} of the load",
    symptom="The residual opposes the motion, and is the larger the harder the joint works.",
    causes="sliding teeth (worm, hypoid or planetary gears), bearings under load, too little lubricant",
    remedy="lubricate, check the gear's efficiency; add the loss to the feed-forward",
    record="the same motion with at least two payloads, in both directions",
    axis="load",
    formula=lambda load, direction: np.abs(load) * direction,
    parameters=(Quantity(name="a", unit="1", meaning="share of the torque that is lost", lower=0.0, upper=1.0),),
)
