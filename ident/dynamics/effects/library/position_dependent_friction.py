"""Dry friction that changes along the travel, in place of Coulomb friction."""

from collections.abc import Sequence

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes, Suggestion
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats

_KNOTS = 9


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Cubic splines over q, each 1 at one knot and 0 at the others, constant beyond, times sgn v (n, dof, 9)."""
    from scipy.interpolate import CubicSpline

    motion, low, high = inputs.motion, np.asarray(shapes["low"]), np.asarray(shapes["high"])
    spline = CubicSpline(np.arange(_KNOTS), np.eye(_KNOTS))
    step = np.where(high > low, high - low, 1.0) / (_KNOTS - 1)  # a joint that stood still has no travel
    cardinal: Floats = spline(np.clip((motion.position - low) / step, 0, _KNOTS - 1))
    return cardinal * motion.direction[:, :, None]


def suggest(inputs: EffectInputs, residual: Floats) -> list[Suggestion]:
    """Suggest the travel of each joint in the rows that have a residual."""
    position = np.where(np.isfinite(residual), inputs.motion.position, np.nan)
    return [{"low": np.fmin.reduce(position), "high": np.fmax.reduce(position)}]


def merge(suggestions: Sequence[Suggestion]) -> Suggestion:
    """Return the travel of each joint in all recordings; 0 to 0 where no row has told it."""
    low = np.fmin.reduce([travel["low"] for travel in suggestions])
    high = np.fmax.reduce([travel["high"] for travel in suggestions])
    return {"low": np.nan_to_num(low), "high": np.nan_to_num(high)}


def _segments(shapes: Shapes, values: Floats) -> dict[str, Floats]:
    """Cubic polynomials (8 segments, 4 coefficients) of the curve through `values` (9,), over the distance."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.linspace(shapes["low"], shapes["high"], _KNOTS), values)
    return {"segments": spline.c.T}


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
            meaning=f"position of the {place} of these places, the {extreme} in the training data",
            initial_guesses=(guess,),
            searched=False,
        )
        for name, place, extreme, guess in (("low", "first", "lowest", -1.0), ("high", "last", "highest", 1.0))
    ),
    local_shapes=True,
    suggest=suggest,
    merge=merge,
    columns=columns,
    c=CCode(
        constants=_segments,
        statements="""
            const real inside = q < low ? low : q > high ? high : q;
            const real place = (inside - low) * 8 / (high - low);
            const int k = place >= 8 ? 7 : (int)place;
            const real x = inside - (low + (high - low) * (real)k / 8);
            const real *p = &segments[i * 32 + k * 4];""",
        expression="(((p[0] * x + p[1]) * x + p[2]) * x + p[3]) * direction",
    ),
)
