"""Friction in the balls at both ends of the rods of a delta robot."""

from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="The balls at both ends of the rods rub.",
    size="{mu}, and {c}",
    symptom="The residuals of all joints oppose the motion of the rods; a joint feels it even while it stands still.",
    causes="worn or dry ball cups, springs that press the cups on too hard, dirt",
    remedy="clean or replace the cups, check the springs of the rods",
    record="one joint moving alone at a time, fast and slowly, while the others hold their places",
    equation="sum over the balls of (mu w/|w| + c w) . dw/dv, w: rod against arm or platform, mu >= 0, c >= 0",
    axis="velocity",
    mechanisms=("delta",),
    whole_robot=True,
    formula=lambda balls_dry, balls_viscous: (balls_dry, balls_viscous),
    parameters=(
        Quantity(name="mu", unit="N m", meaning="dry friction of the balls at one end of a limb's rods", lower=0.0),
        Quantity(name="c", unit="N m s/rad", meaning="viscous friction of the same", lower=0.0),
    ),
    on_arm=True,
)
