"""Smooth curves over the travel of a joint: cubic splines with their knots evenly from its lowest to its highest
position in the training data."""

from collections.abc import Sequence

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Shapes, Suggestion
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats

KNOTS = 9


def cardinals(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Cubic splines over q (n, dof, 9), each 1 at one knot and 0 at the others, constant beyond the travel."""
    from scipy.interpolate import CubicSpline

    low, high = np.asarray(shapes["low"]), np.asarray(shapes["high"])
    spline = CubicSpline(np.arange(KNOTS), np.eye(KNOTS))
    step = np.where(high > low, high - low, 1.0) / (KNOTS - 1)  # a joint that stood still has no travel
    return spline(np.clip((inputs.motion.position - low) / step, 0, KNOTS - 1))


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

    spline = CubicSpline(np.linspace(shapes["low"], shapes["high"], KNOTS), values)
    return {"segments": spline.c.T}


def c_code(factor: str = "") -> CCode:
    """The curve as C, times `factor`."""
    return CCode(
        constants=_segments,
        statements="""
            const real inside = q < low ? low : q > high ? high : q;
            const real place = (inside - low) * 8 / (high - low);
            const int k = place >= 8 ? 7 : (int)place;
            const real x = inside - (low + (high - low) * (real)k / 8);
            const real *p = &segments[i * 32 + k * 4];""",
        expression=f"(((p[0] * x + p[1]) * x + p[2]) * x + p[3]){factor}",
    )


TRAVEL = ("low", "high")
"""Shapes that hold the ends of the travel."""
SHAPES = tuple(
    Quantity(
        name=name,
        unit="{position}",
        meaning=f"position of the {place} of these places, the {extreme} in the training data",
        initial_guesses=(guess,),
        searched=False,
    )
    for name, place, extreme, guess in zip(TRAVEL, ("first", "last"), ("lowest", "highest"), (-1.0, 1.0), strict=True)
)
