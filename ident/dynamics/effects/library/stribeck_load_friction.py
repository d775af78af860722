"""Stribeck friction that grows with the torque that the gear transmits."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.library import stribeck
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """|load| exp(-(v / v_s)^2) sgn v (n, dof, 1); the bump is the mean over each sample."""
    return np.abs(inputs.load)[:, :, None] * stribeck.columns(inputs, shapes)


effect = Additive(
    sentence="Near standstill the joint rubs harder than when it moves, and the more so the harder it works.",
    size="{a:%} of the load, below some {v_s}",
    symptom="The residual peaks on both sides of a reversal, the higher the larger the load there.",
    causes="teeth and bearings under load whose grease carries only at speed",
    remedy="lubricate; keep reversals away from where the load is large; add the term to the feed-forward",
    record="slow strokes with reversals where the load is large and where it is small, with two payloads",
    axis="velocity",
    contains=("load_dependent_friction",),  # beyond all speeds, v_s is of no effect
    formula=lambda load, qd, direction, v_s: np.abs(load) * np.exp(-((qd / v_s) ** 2)) * direction,
    parameters=(
        Quantity(
            name="a", unit="1", meaning="share of the torque that is lost at standstill alone", lower=0.0, upper=1.0
        ),
    ),
    shapes=stribeck.effect.shapes,
    columns=columns,
)
