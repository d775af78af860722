"""Offset of the encoder's zero from that of the rig file."""

from ident.dynamics import mechanisms
from ident.dynamics.effects.base import Quantity, Signal
from ident.dynamics.mechanisms.urdf import Urdf
from recordings.rig import Rig


def impossible(rig: Rig, joint: int) -> str | None:
    """Other parameters of the links do the same at the first joint of an upright arm, and at the last one."""
    mechanism = mechanisms.create(rig)
    replaced = isinstance(mechanism, Urdf) and not mechanism.visible_zeros[joint]
    return "The parameters of the links contain what the zero of this joint changes." if replaced else None


effect = Signal(
    sentence="The encoder's zero is not where the rig file says.",
    size="{c}",
    symptom="The residuals vary slowly with the angle, like weight that is computed for the wrong place.",
    causes="a home position that was set by eye, a coupling that slipped, an encoder that was exchanged",
    remedy="set the zero anew with a jig, or enter the offset into the rig file",
    record="slow motion over the whole travel of all joints, with the largest load",
    axis="position",
    mechanisms=("delta", "urdf"),
    impossible=impossible,
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
