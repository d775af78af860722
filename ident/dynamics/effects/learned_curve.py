"""Curves learned from what no effect explains, as an effect: they lower the error while the physics is looked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

Variable = Literal["position", "velocity", "acceleration", "load", "time"]
Multiplier = Literal["one", "direction", "velocity"]


@dataclass(frozen=True)
class LearnedCurve:
    """Torque of one joint over one variable: straight lines between knots, level beyond them."""

    joint: int
    """Whose torque it is, from 1."""
    variable: Variable
    variable_joint: int
    """Whose variable it is, from 1."""
    multiplier: Multiplier
    """What the values are multiplied with: nothing, the direction of the joint's motion, or its velocity."""
    knots: tuple[float, ...]
    """(k,) rising; [rad, rad/s, rad/s^2, N m or s]."""
    values: tuple[float, ...]
    """(k,) [N m], or [N m s/rad] where they are multiplied with the velocity."""

    def variable_values(self, view: EffectInputs) -> Floats:
        """(n,) the variable."""
        if self.variable == "time":
            return view.time
        where = view.rigid if self.variable == "load" else getattr(view.motion, self.variable)
        signal: Floats = where[:, self.variable_joint - 1]
        return signal

    def factor(self, view: EffectInputs) -> Floats:
        """(n,) what its values are multiplied with."""
        own = view.motion.velocity[:, self.joint - 1]
        if self.multiplier == "velocity":
            return own
        factor: Floats = (
            view.motion.direction[:, self.joint - 1] if self.multiplier == "direction" else np.ones_like(own)
        )
        return factor

    def torque(self, view: EffectInputs) -> Floats:
        """(n,) [N m]."""
        signal = self.variable_values(view)
        level = np.interp(np.nan_to_num(signal), self.knots, self.values)
        torque: Floats = np.where(np.isfinite(signal), level, np.nan) * self.factor(view)
        return torque


def learned_effect(curves: Sequence[LearnedCurve]) -> Additive:
    """The `curves` together, as an effect whose coefficient is 1 where they are as they were learned."""

    def columns(view: EffectInputs, shapes: Shapes) -> Floats:
        torque = np.where(np.isfinite(view.motion.velocity), 0.0, np.nan)
        for curve in curves:
            torque[:, curve.joint - 1] += curve.torque(view)
        return torque[:, :, None]

    over = ", ".join(sorted({curve.variable for curve in curves}))
    return Additive(
        sentence=f"A stand-in: curves over {over}, learned from a recording; nothing says what causes them.",
        symptom="The residual is a smooth curve over that.",
        causes="not known: no effect of the library explains it",
        remedy="look for what depends on that; until it is found, the curve takes its place",
        equation="a f(variable), f as learned",
        axis="position" if curves[0].variable == "position" else "velocity",
        coefficients=(Quantity(name="a", unit="1", meaning="share of the learned curve"),),
        columns=columns,
    )


def effect_file_text(curves: Sequence[LearnedCurve], about: str) -> str:
    """The text of an effect file that holds the `curves`."""
    own = ",\n".join(f"        {curve!r}" for curve in curves)
    return (
        f'"""Stand-in for an effect that is not known yet: curves learned from {about}."""\n\n'
        "from ident.dynamics.effects.learned_curve import LearnedCurve, learned_effect\n\n"
        f"effect = learned_effect(\n    [\n{own},\n    ]\n)\n"
    )
