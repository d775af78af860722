"""Friction that decreases or increases during the run, as with temperature."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """v exp(-t / T) and sgn v exp(-t / T) (n, dof, 2)."""
    # Growing friction reaches 1 at the end, whatever the length of the run.
    end = inputs.time.max() if inputs.end is None else inputs.end
    origin = end if shapes["T"] < 0 else 0.0
    fading = np.exp(-(inputs.time - origin) / shapes["T"])[:, None]
    pair: Floats = np.stack([inputs.motion.velocity * fading, inputs.motion.direction * fading], axis=2)
    return pair


effect = Additive(
    sentence="Friction changes during the run, most of all at its beginning.",
    symptom="The residual opposes the motion, and shrinks or grows from cycle to cycle.",
    causes="cold grease that warms up; a brake or seal that heats up and grips",
    remedy="warm the machine up before recording; let the feed-forward follow the temperature",
    equation="(a v + b sgn v) exp(-t / T)",
    axis="time",
    same_sign=True,
    coefficients=(
        Quantity(name="a", unit="{effort} s/{position}", meaning="viscous part at the beginning"),
        Quantity(name="b", unit="{effort}", meaning="dry part at the beginning"),
    ),
    shapes=(
        Quantity(
            name="T",
            unit="s",
            meaning="time constant; negative where friction grows",
            lower=-1e4,
            upper=1e4,
            max_durations=3.0,  # a slower drift is a straight line over time
            initial_guesses=(3.0, 8.0, 20.0, 60.0, 300.0, -10.0, -60.0),
        ),
    ),
    columns=columns,
    c=CCode(
        expression="(a * qd + b * direction) * exp(-t / T)",
        impossible=lambda shapes: (
            "it grows until the end of the run, which is not known" if shapes["T"] < 0 else None
        ),
    ),
)
