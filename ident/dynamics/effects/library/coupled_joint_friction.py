"""Friction of a joint's own bearing, where its motor turns with another joint, too."""

from ident.dynamics.effects.base import Additive, Quantity
from recordings.rig import Rig


def impossible(rig: Rig, joint: int) -> str | None:
    """Without a coupling, motor and joint turn together, so that the base model has the friction of both."""
    if any(coupling.of == joint + 1 for coupling in rig.couplings):
        return None
    return "The motor turns with its own joint alone (no couplings), so the base model has the bearing's friction."


effect = Additive(
    sentence="The joint's own bearing rubs, beside its motor, which turns with another joint as well.",
    size="{b}, and {a}",
    symptom="The residual opposes the joint's own motion, even where the other joint makes its motor stand still.",
    causes="bearings, seals and cables of a wrist whose motors work through a differential or hollow shafts",
    remedy="nothing is broken; a feed-forward wants the friction at the joint's own speed beside the motor's",
    record="each joint alone and both together, such that the coupled joint moves while its motor stands still",
    axis="velocity",
    mechanisms=("urdf",),
    impossible=impossible,
    formula=lambda qd, direction: (qd, direction),
    parameters=(
        Quantity(name="a", unit="{effort} s/{position}", meaning="viscous friction of the bearing", lower=0.0),
        Quantity(name="b", unit="{effort}", meaning="Coulomb friction of the bearing", lower=0.0),
    ),
)
