"""Constant torque; equivalent to Coulomb friction that differs between the directions."""

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The drive must give a constant torque, whatever the joint does.",
    size="{a}",
    symptom="The residual is shifted up or down by the same amount everywhere.",
    causes="an amplifier's zero, a cable's pull, a spring, or dry friction that differs between the directions",
    remedy="zero the amplifier's current or torque measurement, relieve the cables, record both directions equally",
    record="the same strokes in both directions, and a stop at one place from either side",
    axis="velocity",
    mechanisms=("delta", "axes"),  # the base model of a URDF has it
    formula=lambda: 1.0,
    parameters=(Quantity(name="a", unit="{effort}", meaning="the constant torque"),),
)
