"""Eccentricity of an encoder disc."""

import numpy as np

from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats
from recordings.rig import Rig

_ITERATIONS = 3
_MAX_AMPLITUDE = np.pi / 180
"""A joint's encoder that is off by more would have been noticed [rad]."""


def position(measured: Floats, rig: Rig, values: Values) -> Floats:
    """Solve q + a sin N q + b cos N q = measured for the true angle q (n, dof), by Newton's method."""
    a, b, N = values["a"], values["b"], values["N"]
    true = measured
    for _ in range(_ITERATIONS):
        sine, cosine = np.sin(N * true), np.cos(N * true)
        error = a * sine + b * cosine
        slope = 1 + N * (a * cosine - b * sine)
        true = true - (true + error - measured) / np.maximum(slope, 0.1)
    return true


def position_slopes(true: Floats, rig: Rig, values: Values) -> tuple[Floats, Floats]:
    """Derivatives of the inverse function, at the `true` angle (n, dof)."""
    a, b, N = values["a"], values["b"], values["N"]
    sine, cosine = np.sin(N * true), np.cos(N * true)
    slope = 1 + N * (a * cosine - b * sine)
    bend = -(N**2) * (a * sine + b * cosine)
    return 1 / slope, -bend / slope**3


def impossible(rig: Rig, joint: int) -> str | None:
    """The error is a wave over an angle."""
    return "A prismatic joint has no turns." if rig.joint_types[joint] == "prismatic" else None


effect = Signal(
    sentence="The encoder's disc does not run true: within a turn it reads too much, then too little.",
    symptom="The residual is a wave over the angle that grows with acceleration and with the square of speed.",
    causes="a disc or magnet that is not centred on its shaft, of the joint or of the motor",
    remedy="centre the encoder, or use one that compensates; a table of its error can be recorded once",
    equation="measured q = q + a sin N q + b cos N q",
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
    position=position,
    position_slopes=position_slopes,
    c=CCode(
        statements="""
            const real measured = q;
            for (int step = 0; step < 3; step++) {
                const real error = a * sin(N * q) + b * cos(N * q);
                const real rise = 1 + N * (a * cos(N * q) - b * sin(N * q));
                q -= (q + error - measured) / (rise > R(0.1) ? rise : R(0.1));
            }
            const real slope = 1 + N * (a * cos(N * q) - b * sin(N * q));
            const real bend = -N * N * (a * sin(N * q) + b * cos(N * q));
            qdd = qdd / slope - bend * qd * qd / (slope * slope * slope);
            qd /= slope;""",
    ),
)
