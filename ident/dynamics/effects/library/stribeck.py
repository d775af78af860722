"""Stribeck friction: dry friction that is higher at low speed."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

_INSTANT = 1e-4
"""Change of the velocity within a sample, over the Stribeck speed, below which it does not matter."""


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """exp(-(v / v_s)^2) sgn v (n, dof, 1), the mean over each sample: a slow one sees much of the bump at once.

    Its integral over the speed is an error function of the absolute value.
    """
    from scipy.special import erf

    motion = inputs.motion
    u, half = motion.velocity / shapes["v_s"], motion.sweep / shapes["v_s"]
    bump = np.exp(-(u**2)) * motion.direction
    swept = np.abs(half) > _INSTANT
    u, half = u[swept], half[swept]
    bump[swept] = 0.25 * np.sqrt(np.pi) * (erf(np.abs(u + half)) - erf(np.abs(u - half))) / half
    return bump[:, :, None]


effect = Additive(
    sentence="Near standstill the joint rubs harder than when it moves: friction falls as speed rises.",
    size="{a}, below some {v_s}",
    symptom="The residual peaks on both sides of a reversal and vanishes above some speed.",
    causes="grease that carries the sliding parts only at speed; seals; a dry or worn bearing",
    remedy="lubricate; keep reversals away from where precision matters; add the term to the feed-forward",
    record="slow strokes with reversals, several of them below the speed at which the peak vanishes",
    axis="velocity",
    formula=lambda qd, direction, v_s: np.exp(-((qd / v_s) ** 2)) * direction,
    parameters=(Quantity(name="a", unit="{effort}", meaning="friction at standstill beyond Coulomb's", lower=0.0),),
    shapes=(
        Quantity(
            name="v_s",
            unit="{position}/s",
            meaning="Stribeck speed: there the excess has fallen to 37 %",
            lower=1e-4,
            upper=10.0,
            initial_guesses=(0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6),
        ),
    ),
    columns=columns,
)
