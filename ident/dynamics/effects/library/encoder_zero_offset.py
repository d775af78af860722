"""Offset of the encoder's zero from that of the rig file."""

import numpy as np

from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats
from recordings.rig import Rig


def position(measured: Floats, rig: Rig, values: Values) -> Floats:
    """Subtract the offset from the measured angle (n, dof)."""
    true: Floats = measured - values["c"]
    return true


effect = Signal(
    sentence="The encoder's zero is not where the rig file says.",
    symptom="The residuals vary slowly with the angle, like weight that is computed for the wrong place.",
    causes="a home position that was set by eye, a coupling that slipped, an encoder that was exchanged",
    remedy="set the zero anew with a jig, or enter the offset into the rig file",
    equation="measured q = q + c",
    axis="position",
    mechanisms=("delta",),
    parameters=(
        Quantity(
            name="c",
            unit="{position}",
            meaning="what is read too much",
            lower=-0.35,
            upper=0.35,
            initial_guesses=(0.005,),
        ),
    ),
    position=position,
    position_slopes=lambda true, rig, values: (np.ones_like(true), np.zeros_like(true)),
    c=CCode(statements="q -= c;"),
)
