"""Torque that depends on the position alone: any smooth curve, in place of several effects of a given shape."""

import numpy as np

from ident.dynamics.effects import travel_curve
from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="Something pushes or pulls the joint by an amount that depends on its position, whatever the direction.",
    symptom="The residual is one smooth curve over the position, whatever the direction.",
    causes="a counterbalance, a gas spring, a cable or hose that is stretched, a stop of rubber, a bent guide",
    remedy="look what touches or pulls the joint there; or give the feed-forward the curve over the position",
    record="slow strokes over the whole travel, in both directions",
    equation="g(q), g a spline through g_1, g_2, g_3, g_4, g_5, g_6, g_7, g_8, g_9, evenly from low to high",
    curve=True,
    axis="position",
    usual_travel=4 * np.pi,  # what is tied to both parts does not turn for ever
    contains=("torque_offset", "joint_spring", "axis_weight", "arm_com_offset", "arm_mass_mismatch"),
    parameters=tuple(
        Quantity(name=f"g_{knot}", unit="{effort}", meaning=f"torque at place {knot}")
        for knot in range(1, travel_curve.KNOTS + 1)
    ),
    shapes=travel_curve.SHAPES,
    local_shapes=True,
    suggest=travel_curve.suggest,
    merge=travel_curve.merge,
    columns=travel_curve.cardinals,
    c=travel_curve.c_code(),
)
