"""Inertia of uniform rods (forearms), whose mass the base model lumps at platform and arms."""

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The forearms' mass is spread over their length, not gathered at their ends.",
    size="{m_d}",
    symptom="The residual follows accelerations, in all joints, a few per mille to percent of the torque.",
    causes="every real delta robot has it; the base model of the paper leaves it out",
    remedy="add it to the model; nothing is wrong with the machine",
    record="fast motion of the platform in all directions",
    equation="m_d times the inertia and weight of a uniform rod in each limb, m_d >= 0",
    axis="acceleration",
    mechanisms=("delta",),
    whole_robot=True,
    meanings={"m_p": "mass of the platform with its load, without the forearms"},
    mandatory=True,
    formula=lambda rods: rods,
    parameters=(Quantity(name="m_d", unit="kg", meaning="mass of the two rods of one limb", lower=0.0),),
    bodies=("m_d",),
)
