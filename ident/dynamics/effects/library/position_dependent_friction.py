"""Dry friction that changes along the travel, in place of Coulomb friction."""

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import travel_curve
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Splines over q times sgn v (n, dof, 9)."""
    return travel_curve.cardinals(inputs, shapes) * inputs.motion.direction[:, :, None]


effect = Additive(
    sentence="The joint rubs harder at some places of its travel than at others, in both directions.",
    symptom="The residual opposes the motion by an amount that depends on the position alone.",
    causes="a cable or tendon that is bent or wraps around, a bent spindle, a guide that is out of line, worn places",
    remedy="look where it rubs: align guides, relieve cables; or give the feed-forward the curve over the position",
    record="slow strokes over the whole travel, in both directions, at two speeds",
    equation="f(q) sgn v in place of c_c sgn v, f a spline through f_1, f_2, f_3, f_4, f_5, f_6, f_7, f_8, f_9 >= 0, "
    "evenly from low to high",
    curve=True,
    axis="position",
    needs=("both directions",),
    replaces="c_c",
    parameters=tuple(
        Quantity(name=f"f_{knot}", unit="{effort}", meaning=f"dry friction at place {knot}", lower=0.0)
        for knot in range(1, travel_curve.KNOTS + 1)
    ),
    shapes=travel_curve.SHAPES,
    local_shapes=True,
    suggest=travel_curve.suggest,
    merge=travel_curve.merge,
    columns=columns,
    c=travel_curve.c_code(" * direction"),
)
