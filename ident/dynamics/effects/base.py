"""What an effect says of itself: one description for all that the rest of the program asks.

Two kinds: `Additive` is further torque, linear in coefficients, whose columns follow from the motion (by a formula,
or by following an internal state along it). `Signal` stands between the machine and what was measured of it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from recordings.recording import Floats
from recordings.rig import Rig

SignatureAxis = Literal["position", "velocity", "acceleration", "motor angle", "load", "time"]
Shapes = Mapping[str, float]
"""Shape parameters by name."""
Suggestion = Mapping[str, Any]
"""Where a search may begin, by name: shape parameters, and parameters, one for all joints or one for each (dof,)."""
Values = Mapping[str, Floats]
"""Parameters and shapes of a signal effect by name: parameters (dof,), zero for joints that do not have the effect,
or (1,) if it is one of the whole robot; shapes (1,)."""

INFINITE_TIME = 1e9
"""Stands for an instant that does not come [s]."""


def is_infinite(value: float, unit: str) -> bool:
    """Whether `value` is an instant that does not come."""
    return unit == "s" and value >= INFINITE_TIME


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A parameter of an effect."""

    name: str
    unit: str
    """{effort} stands for N m or N, {position} for rad or m."""
    meaning: str
    lower: float = -np.inf
    """Physical range: what a fit finds outside of it is evidence against the effect."""
    upper: float = np.inf
    initial_guesses: tuple[float, ...] = ()
    """Where the search for it begins; several where there may be several valleys. Empty for a coefficient."""
    implausible_bound: Literal["lower", "upper"] | None = None
    """An end of the range at which a search that ends there speaks against the effect."""
    searched: bool = True
    """False where nothing but the `starts` is meant, such as a number of something."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What both kinds say of themselves."""

    sentence: str
    """What it is, for a person at the bench."""
    symptom: str
    """What it looks like in a recording."""
    causes: str
    """What usually causes it."""
    remedy: str
    """What to do about it."""
    equation: str
    axis: SignatureAxis
    """What to draw the residual over to see it."""
    mechanisms: tuple[str, ...] = ("delta", "axes")
    whole_robot: bool = False
    """True where all joints share its parameters; else every joint has its own, and some joints may not have it."""
    contains: tuple[str, ...] = ()
    """Other effects that are special cases of this one."""
    mandatory: bool = False
    """True of any real machine of this kind, so that finding it is no finding."""
    shapes: tuple[Quantity, ...] = ()
    """Further parameters, the same for all joints, that say of what shape the effect is; each with its `starts`."""
    suggest: Callable[[EffectInputs, Floats], Sequence[Suggestion]] | None = None
    """More shapes to begin with, from a residual (n, dof) [N m] at the view's instants, which may be few a second; of
    a signal also values of its parameters."""
    step: float = 1e-4
    """Change of a searched parameter, relative, by which a fit sees where to go: larger where the torque jumps."""
    multistart: int = 1
    """From so many of the best starts a search begins."""
    repeated: bool = False
    """True where several of it may be there, with different shapes: the lines of a spectrum."""
    unobservable: Callable[[Rig, bool], str | None] = lambda rig, torque_measured: None
    """Why a recording of this rig cannot show it, if so; the flag: the torque itself was measured, no voltage."""


@dataclass(frozen=True, kw_only=True)
class Additive(Effect):
    """Torque that the amplifier must give in addition: sum of coefficient * column."""

    coefficients: tuple[Quantity, ...]
    """c of them, per joint or for the whole robot."""
    columns: Callable[[EffectInputs, Shapes], Floats]
    """Torque per unit of each coefficient (n, dof, c); NaN where the motion is. That of a joint must not depend on
    its own coefficients, nor on anything measured but the motion."""


@dataclass(frozen=True, kw_only=True)
class Signal(Effect):
    """A distortion of what was measured. Its parameters are searched, not solved for."""

    parameters: tuple[Quantity, ...]
    """Per joint, or for the whole robot, each with its `starts`; at zero (all of them) there is no distortion."""
    position: Callable[[Floats, Rig, Values], Floats] | None = None
    """The true position (n, dof), given the measured one."""
    rig: Callable[[Rig, Values], Rig] | None = None
    """The true rig, given the one in the file."""
    report: Callable[[Floats, EffectInputs, Values], Floats] | None = None
    """The torque (n, dof) that the rig's map makes of what is reported, given the true torque (n, dof)."""
    pointwise: bool = True
    """False where what is reported at an instant depends on the true torque at other instants, as with a delay."""
