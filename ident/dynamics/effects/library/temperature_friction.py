"""Friction that falls with the measured temperature."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats

REFERENCE = 25.0
"""Temperature at which viscous and Coulomb friction have the values of the model [degC]."""


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """(c_v v + c_c sgn v) (T - 25 degC) (n, dof, 1); 0 on joints whose temperature was not measured."""
    motion, numbers = inputs.motion, range(1, inputs.motion.velocity.shape[1] + 1)
    viscous, coulomb = (np.array([inputs.parameters[f"{name}{i}"] for i in numbers]) for name in ("c_v", "c_c"))
    warmth = inputs.temperature - REFERENCE
    warmth = np.where(np.isnan(warmth).all(axis=0), 0.0, warmth)
    friction: Floats = ((viscous * motion.velocity + coulomb * motion.direction) * warmth)[:, :, None]
    return friction


effect = Additive(
    sentence="The joint rubs less the warmer its drive is.",
    symptom="The residual opposes the motion, and falls as the measured temperature rises.",
    causes="grease and oil that get thinner with warmth, seals that soften, clearances that open",
    remedy="warm the machine up before recording; give the feed-forward the temperature",
    equation="(c_v v + c_c sgn v) k (T - 25 degC), k <= 0",
    axis="velocity",
    needs=("temperature",),
    coefficients=(
        Quantity(
            name="k", unit="1/K", meaning="relative change of friction per degree, of that at 25 degC", upper=0.0
        ),
    ),
    columns=columns,
    c=CCode(expression="(c_v * qd + c_c * direction) * k * (temperature - R(25.0))"),
)
