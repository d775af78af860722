"""Inertia of uniform rods (forearms), whose mass the base model lumps at platform and arms."""

from ident.dynamics import rods
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Torque (n, dof, 1) that moves and lifts one uniform rod of 1 kg in each limb."""
    return rods.torque(inputs.rig.geometry, inputs.motion)[:, :, None]


effect = Additive(
    sentence="The forearms' mass is spread over their length, not gathered at their ends.",
    symptom="The residual follows accelerations, in all joints, a few per mille to percent of the torque.",
    causes="every real delta robot has it; the base model of the paper leaves it out",
    remedy="add it to the model; nothing is wrong with the machine",
    equation="m_d times the inertia and weight of a uniform rod in each limb, m_d >= 0",
    axis="acceleration",
    mechanisms=("delta",),
    whole_robot=True,
    meanings={"m_p": "mass of the platform with its load, without the forearms"},
    mandatory=True,
    coefficients=(Quantity(name="m_d", unit="kg", meaning="mass of the two rods of one limb", lower=0.0),),
    columns=columns,
    c=CCode(expression="m_d * rods"),
)
