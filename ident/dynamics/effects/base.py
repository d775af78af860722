"""Descriptions of effects: equations, parameters and texts in one place.

There are two kinds. `Additive` adds torque that is linear in coefficients; its regressor columns are computed from
the motion, by a formula or by integrating an internal state. `Signal` distorts what is measured of the machine.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats
from recordings.rig import Rig

SignatureAxis = Literal["position", "velocity", "acceleration", "motor angle", "load", "time"]
Friction = Literal["c_v", "c_c"]
"""Viscous or Coulomb friction of the mechanism: the name of its parameters, followed by the number of the joint."""
Need = Literal["temperature", "both directions"]
"""What recordings must hold beyond motion and torque: the drives' temperature, or motion in both directions."""
Shapes = Mapping[str, Any]
"""Shape parameters by name: numbers, or (dof,) where each joint has its own."""
Suggestion = Mapping[str, Any]
"""Initial guesses by name: of shape parameters, and of parameters, one for all joints or one per joint (dof,)."""
Values = Mapping[str, Floats]
"""Parameters and shapes of a signal effect by name. Parameters are (dof,), with zero for joints without the
effect; those of an effect of the whole robot are (1,), like shapes."""

_TYPICAL_SHAPE = 40.0
"""Value of a shape without initial guesses, such as a number of periods per turn."""
INFINITE_TIME = 1e9
"""Stands for an instant after the end of any recording [s]."""


def is_infinite(value: float, unit: str) -> bool:
    """Return whether `value` is a time that stands for infinity."""
    return unit == "s" and value >= INFINITE_TIME


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A parameter of an effect."""

    name: str
    unit: str
    """{effort} stands for N m or N, {position} for rad or m, {turn} for a turn or 2π m."""
    meaning: str
    lower: float = -np.inf
    """Physical range, with `upper`; an estimate outside of it is evidence against the effect."""
    upper: float = np.inf
    initial_guesses: tuple[float, ...] = ()
    """Starting values of the search, several where there may be several local minima. Empty for a coefficient."""
    implausible_bound: Literal["lower", "upper"] | None = None
    """End of the range that is no plausible result: a search that ends there is evidence against the effect."""
    usual: float = np.inf
    """Largest size that hardware usually has; a larger one is possible, but is cautioned."""
    searched: bool = True
    """False where only the `initial_guesses` are possible values, as for an index."""
    reduces_to: str | None = None
    """Effect that is left if this parameter is zero: one that the effect contains."""
    max_durations: float | None = None
    """Largest plausible size of a time constant, in durations of the longest training recording."""
    min_use: float | None = None
    """Smallest plausible product of the inverse of a voltage with the largest recorded voltage, held-out recordings
    included: a limit that was never approached is not known."""

    @property
    def usual_range(self) -> tuple[float, float]:
        """The values between which hardware usually stays, ends excluded."""
        low = self.lower if self.implausible_bound == "lower" else -self.usual
        high = self.upper if self.implausible_bound == "upper" else self.usual
        return low, high

    def unit_on(self, rig: Rig, joint: int) -> str:
        """Its unit on a `joint` (from 0) of `rig`."""
        effort, position = rig.effort_units[joint], rig.position_units[joint]
        return self.unit.format(effort=effort, position=position, turn="turn" if position == "rad" else "2π m")


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Description that both kinds have in common."""

    sentence: str
    """What the effect is, in one sentence for a technician."""
    symptom: str
    """How it shows in a recording."""
    causes: str
    """Usual causes."""
    remedy: str
    """Recommended action."""
    equation: str
    axis: SignatureAxis
    """Variable over which a plot of the residual shows the effect."""
    mechanisms: tuple[str, ...] = ("delta", "axes")
    impossible: Callable[[Rig, int], str | None] = lambda rig, joint: None
    """Return why a joint (from 0) of this rig cannot have the effect, or None."""
    joints: tuple[int, ...] | None = None
    """Joints (from 0) to which a diagnosis restricts the effect; None: all that can have it."""
    needs: tuple[Need, ...] = ()
    memory: bool = False
    """True if the torque at an instant depends on earlier instants: the motion is then stepped in time."""
    replaces: Friction | None = None
    """Friction of the mechanism in whose place the effect stands, on its joints."""
    whole_robot: bool = False
    """True if all joints share its parameters; otherwise each joint that has the effect has its own."""
    contains: tuple[str, ...] = ()
    """Other effects that are special cases of this one."""
    mandatory: bool = False
    """Always included; never reported as a finding."""
    max_amplitude: float | None = None
    """Largest plausible root of the sum of squares of the local parameters, for a wave's sine and cosine."""
    meanings: Mapping[str, str] = field(default_factory=dict, hash=False)
    """Meanings that parameters of the mechanism have beside this effect, by their names."""
    differential: bool = False
    """True if hardly more than differences between joints show: on all joints alike, the base model imitates it."""
    same_sign: bool = False
    """True if hardware gives the local parameters of an instance the same sign."""
    shapes: tuple[Quantity, ...] = ()
    """Nonlinear shape parameters, each with its `initial_guesses`."""
    local_shapes: bool = False
    """True if each joint has its own shapes, of an additive effect; otherwise all joints share them."""
    suggest: Callable[[EffectInputs, Floats], Sequence[Suggestion]] | None = None
    """Suggest further initial guesses from a residual (n, dof) [N m] at the instants of the inputs, which may be
    decimated: shapes, and for a signal effect also its parameters. Of local shapes, nothing else is tried then."""
    merge: Callable[[Sequence[Suggestion]], Suggestion] | None = None
    """Merge what several recordings suggest; None: each of the suggestions is tried."""
    step: float = 1e-4
    """Relative finite-difference step of searched parameters; larger where the torque is discontinuous."""
    discontinuous: bool = False
    """True if the torque may change abruptly with its searched parameters, so that a search gets stuck."""
    multistart: int = 1
    """Number of the best initial guesses from which a search starts."""
    curve: bool = False
    """True if its coefficients are the values of a curve, which imitates much that is unknown: it is added only where
    little is left then."""
    repeated: bool = False
    """True if it may occur several times with different shapes, as spectral lines do."""
    c: CCode | None = None
    """The effect as C; None if no controller can step it."""
    unobservable: Callable[[Rig, bool], str | None] = lambda rig, torque_measured: None
    """Return why a recording of this rig cannot show the effect, or None. The flag is true if torque was recorded,
    not voltage."""

    def possible_joints(self, rig: Rig) -> tuple[int, ...]:
        """Joints (from 0) of `rig` that can have the effect; all of them for an effect of the whole robot."""
        joints = range(rig.dof) if self.joints is None else self.joints
        return tuple(joint for joint in joints if self.whole_robot or self.impossible(rig, joint) is None)

    @property
    def typical_shapes(self) -> Floats:
        """(s,) middle one of the initial guesses of each shape parameter."""
        guesses = [shape.initial_guesses or (_TYPICAL_SHAPE,) for shape in self.shapes]
        return np.array([values[len(values) // 2] for values in guesses], float)

    def why_unobservable(self, rig: Rig, torque_measured: bool, temperature_measured: bool) -> str | None:
        """Return why recordings of this rig cannot show the effect on any joint, or None."""
        if "temperature" in self.needs and not temperature_measured:
            return "No temperature was recorded (columns temperature_1 ...)."
        if not self.possible_joints(rig):
            return self.impossible(rig, 0)
        return self.unobservable(rig, torque_measured)


@dataclass(frozen=True, kw_only=True)
class Additive(Effect):
    """Additional torque that the drive must supply: the sum of coefficient times column."""

    coefficients: tuple[Quantity, ...]
    """The c coefficients, per joint or for the whole robot."""
    on_arm: bool = False
    """True if the torque acts on the arm, so that springs and backlash between motor and arm transmit it."""
    columns: Callable[[EffectInputs, Shapes], Floats]
    """Torque per unit of each coefficient (n, dof, c); NaN where the motion is NaN. It must not depend on the
    coefficients, nor on any measurement but the motion."""


@dataclass(frozen=True, kw_only=True)
class Signal(Effect):
    """A distortion of the measurement, nonlinear in its parameters."""

    parameters: tuple[Quantity, ...]
    """Per joint or for the whole robot, each with its `initial_guesses`. With all at zero there is no distortion."""
    position: Callable[[Floats, Rig, Values], Floats] | None = None
    """Compute the true position (n, dof) from the measured one."""
    position_slopes: Callable[[Floats, Rig, Values], tuple[Floats, Floats]] | None = None
    """Compute first and second derivative (n, dof) of the true position by the measured one, at true positions; None:
    they are computed by differences."""
    rig: Callable[[Rig, Values], Rig] | None = None
    """Compute the true rig from the one in the file."""
    report: Callable[[Floats, EffectInputs, Values], Floats] | None = None
    """Compute, from the true torque (n, dof), the torque (n, dof) that the rig's map gives for what is reported."""
    perturbed_report: Callable[[Floats, EffectInputs, Values], Floats] | None = None
    """Compute the report with an error of one standard deviation in what the equation idealizes, such as the instant
    of an impact, which widens the intervals; None: there is no such error."""
    pointwise: bool = True
    """False if the report at an instant depends on the true torque at other instants, as with a delay."""
    offset: bool = False
    """True if the report is the true torque plus a torque that does not depend on it."""
