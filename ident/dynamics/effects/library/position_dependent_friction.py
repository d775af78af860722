"""Dry friction that changes along the travel, in place of Coulomb friction."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes, Suggestion
from recordings.recording import Floats

_KNOTS = 9


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Cubic splines over q, each 1 at one knot and 0 at the others, constant beyond, times sgn v (n, dof, 9)."""
    from scipy.interpolate import CubicSpline

    motion = inputs.motion
    spline = CubicSpline(np.linspace(shapes["low"], shapes["high"], _KNOTS), np.eye(_KNOTS))
    cardinal: Floats = spline(np.clip(motion.position, shapes["low"], shapes["high"]))
    return cardinal * motion.direction[:, :, None]


def suggest(inputs: EffectInputs, residual: Floats) -> list[Suggestion]:
    """Suggest the travel of each joint, and that of all."""
    low, high = (bound(inputs.motion.position, axis=0) for bound in (np.nanmin, np.nanmax))
    travels = {*zip(low.tolist(), high.tolist(), strict=True), (float(low.min()), float(high.max()))}
    return [{"low": first, "high": last} for first, last in sorted(travels)]


effect = Additive(
    sentence="The joint rubs harder at some places of its travel than at others, in both directions.",
    symptom="The residual opposes the motion by an amount that depends on the position alone.",
    causes="a cable or tendon that is bent or wraps around, a bent spindle, a guide that is out of line, worn places",
    remedy="look where it rubs: align guides, relieve cables; or give the feed-forward the curve over the position",
    equation="f(q) sgn v in place of c_c sgn v, f a spline through f_1, f_2, f_3, f_4, f_5, f_6, f_7, f_8, f_9 >= 0, "
    "evenly from low to high",
    curve=True,
    axis="position",
    needs=("both directions",),
    replaces="c_c",
    coefficients=tuple(
        Quantity(name=f"f_{knot}", unit="{effort}", meaning=f"dry friction at place {knot}", lower=0.0)
        for knot in range(1, _KNOTS + 1)
    ),
    shapes=tuple(
        Quantity(
            name=name,
            unit="{position}",
            meaning=f"position of the {place} of these places",
            initial_guesses=(guess,),
            searched=False,
        )
        for name, place, guess in (("low", "first", -1.0), ("high", "last", 1.0))
    ),
    suggest=suggest,
    columns=columns,
)
