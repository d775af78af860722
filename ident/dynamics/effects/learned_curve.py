"""Nonparametric curves learned from the unexplained residual, in the form of an effect."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

Variable = Literal["position", "velocity", "acceleration", "load", "time"]
Multiplier = Literal["one", "direction", "velocity"]


@dataclass(frozen=True)
class LearnedCurve:
    """Torque of one joint as a function of one variable: linear between knots, constant beyond them."""

    joint: int
    """Joint that needs the torque, from 1."""
    variable: Variable
    variable_joint: int
    """Joint whose variable it is, from 1."""
    multiplier: Multiplier = "one"
    """Factor of the values: one, the joint's direction of motion, or its velocity."""
    knots: tuple[float, ...] = ()
    """(k,) ascending [rad, rad/s, rad/s^2, N m or s]; empty while they are not chosen."""
    values: tuple[float, ...] = ()
    """(k,) [N m], or [N m s/rad] if multiplied by the velocity; empty while they are not known."""

    def variable_values(self, inputs: EffectInputs) -> Floats:
        """Return the variable (n,)."""
        if self.variable == "time":
            return inputs.time
        signals = inputs.rigid if self.variable == "load" else getattr(inputs.motion, self.variable)
        return signals[:, self.variable_joint - 1]

    def factor(self, inputs: EffectInputs) -> Floats:
        """Return the factor (n,) of the values."""
        velocity = inputs.motion.velocity[:, self.joint - 1]
        if self.multiplier == "velocity":
            return velocity
        return (
            inputs.motion.direction[:, self.joint - 1] if self.multiplier == "direction" else np.ones_like(velocity)
        )

    def columns(self, inputs: EffectInputs) -> Floats:
        """Compute the torque (n, k) per unit of the value at each knot; NaN where the variable is not known."""
        variable = self.variable_values(inputs)
        known = np.where(np.isfinite(variable), self.factor(inputs), np.nan)
        return hat_functions(variable, self.knots) * known[:, None]

    def torque(self, inputs: EffectInputs) -> Floats:
        """Compute the torque (n,) [N m]."""
        return self.columns(inputs) @ np.array(self.values)


def hat_functions(x: Floats, knots: Sequence[float] | Floats) -> Floats:
    """(n, k) piecewise linear functions of `x` (n,): each is 1 at its knot and 0 at the others; they add up to 1.

    They are constant beyond the outer knots, and arbitrary where `x` is NaN.
    """
    numbers = np.arange(len(knots))
    position = np.interp(np.nan_to_num(x), knots, numbers)
    return np.maximum(1 - np.abs(position[:, None] - numbers), 0.0)


def learned_effect(curves: Sequence[LearnedCurve]) -> Additive:
    """Combine the `curves` in one effect, whose coefficient is 1 for the curves as learned."""
    over = ", ".join(sorted({curve.variable for curve in curves}))
    return Additive(
        sentence=f"Curves over {over}, learned from a recording; their cause is unknown.",
        symptom="The residual is a smooth function of these variables.",
        causes="not known: no effect of the library explains it",
        remedy="look for a cause that depends on these variables; until then, use the learned curve",
        equation="a f(variable), f as learned",
        axis="position" if curves[0].variable == "position" else "velocity",
        parameters=(Quantity(name="a", unit="1", meaning="share of the learned curve"),),
        columns=partial(_learned_columns, curves),
    )


def unknown_curve(curve: LearnedCurve) -> Additive:
    """The effect of a `curve` whose values are not known: they are its coefficients."""
    values = [Quantity(name=f"f{number}_", unit="{effort}", meaning="value") for number in range(len(curve.knots))]
    columns = partial(_unknown_columns, curve)
    return replace(learned_effect([curve]), parameters=tuple(values), columns=columns, curve=True)


def _learned_columns(curves: Sequence[LearnedCurve], inputs: EffectInputs, shapes: Shapes) -> Floats:
    torque = np.where(np.isfinite(inputs.motion.velocity), 0.0, np.nan)
    for curve in curves:
        torque[:, curve.joint - 1] += curve.torque(inputs)
    return torque[:, :, None]


def _unknown_columns(curve: LearnedCurve, inputs: EffectInputs, shapes: Shapes) -> Floats:
    torque = np.zeros((*inputs.motion.velocity.shape, len(curve.knots)))
    torque[:, curve.joint - 1] = curve.columns(inputs)
    return torque


def effect_file_text(curves: Sequence[LearnedCurve], about: str) -> str:
    """Return the text of an effect file with the `curves`."""
    lines = ",\n".join(f"        {curve!r}" for curve in curves)
    return (
        f'"""Curves learned from {about}, in place of an effect that is not known yet."""\n\n'
        "from ident.dynamics.effects.learned_curve import LearnedCurve, learned_effect\n\n"
        f"effect = learned_effect(\n    [\n{lines},\n    ]\n)\n"
    )
