"""Friction that decreases or increases during the run, as with temperature."""

from typing import Any

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import quantities
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def friction(qd: Any, direction: Any, t: Any, T: Any) -> Any:
    """Viscous and dry friction at the beginning, which fade."""
    fading = np.exp(-t / T)
    return qd * fading, direction * fading


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """(n, dof, 2); growing friction reaches its size at the end, whatever the length of the run."""
    end = inputs.time.max() if inputs.end is None else inputs.end
    origin = end if shapes["T"] < 0 else 0.0
    return quantities.columns(friction, inputs, {**shapes, "t": inputs.time[:, None] - origin})


effect = Additive(
    sentence="Friction changes during the run, most of all at its beginning.",
    size="{b}, and {a}, in {T}",
    symptom="The residual opposes the motion, and shrinks or grows from cycle to cycle.",
    causes="cold grease that warms up; a brake or seal that heats up and grips",
    remedy="warm the machine up before recording; let the feed-forward follow the temperature",
    record="one motion repeated from a cold start until nothing changes any more",
    axis="time",
    same_sign=True,
    formula=friction,
    parameters=(
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
            least=2.0,  # what fades sooner is no warmth, but how a motion begins
            initial_guesses=(3.0, 8.0, 20.0, 60.0, 300.0, -10.0, -60.0),
        ),
    ),
    columns=columns,
    c=CCode(
        impossible=lambda shapes: (
            "it grows until the end of the run, which is not known" if shapes["T"] < 0 else None
        ),
    ),
)
