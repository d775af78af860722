"""Offset of the encoder's zero from that of the rig file."""

from ident.dynamics.effects.base import Quantity, Signal

effect = Signal(
    sentence="The encoder's zero is not where the rig file says.",
    symptom="The residuals vary slowly with the angle, like weight that is computed for the wrong place.",
    causes="a home position that was set by eye, a coupling that slipped, an encoder that was exchanged",
    remedy="set the zero anew with a jig, or enter the offset into the rig file",
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
    reading=lambda q, c: q + c,
    bodies=("zero",),
)
