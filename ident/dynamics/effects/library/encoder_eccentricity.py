"""Eccentricity of an encoder disc."""

import numpy as np

from ident.dynamics.effects.base import Quantity, Signal
from recordings.rig import Rig

_MAX_AMPLITUDE = np.pi / 180
"""A joint's encoder that is off by more would have been noticed [rad]."""


def impossible(rig: Rig, joint: int) -> str | None:
    """The error is a wave over an angle."""
    return "A prismatic joint has no turns." if rig.joint_types[joint] == "prismatic" else None


effect = Signal(
    sentence="The encoder's disc does not run true: within a turn it reads too much, then too little.",
    size="{norm}, {N:n} times per {turn}",
    symptom="The residual is a wave over the angle that grows with acceleration and with the square of speed.",
    causes="a disc or magnet that is not centred on its shaft, of the joint or of the motor",
    remedy="centre the encoder, or use one that compensates; a table of its error can be recorded once",
    record="fast strokes over at least one turn of the shaft, and the same strokes slowly",
    axis="motor angle",
    impossible=impossible,
    max_amplitude=_MAX_AMPLITUDE,
    parameters=(
        Quantity(
            name="a",
            unit="{position}",
            meaning="amplitude of the sine",
            lower=-0.3,
            upper=0.3,
            usual=_MAX_AMPLITUDE,
            initial_guesses=(1e-4,),
        ),
        Quantity(
            name="b",
            unit="{position}",
            meaning="amplitude of the cosine",
            lower=-0.3,
            upper=0.3,
            usual=_MAX_AMPLITUDE,
            initial_guesses=(1e-4,),
        ),
    ),
    shapes=(
        Quantity(
            name="N",
            unit="1/{turn}",
            meaning="turns of the disc per turn of the joint",
            lower=1.0,
            upper=400.0,
            initial_guesses=(1.0,),
            searched=False,
        ),
    ),
    suggest=lambda inputs, residual: [{"N": gear} for gear in sorted({drive.gear for drive in inputs.rig.drives})],
    reading=lambda q, a, b, N: q + a * np.sin(N * q) + b * np.cos(N * q),
)
