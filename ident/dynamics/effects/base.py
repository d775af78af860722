"""Descriptions of effects: formulas, parameters and texts in one place.

There are two kinds. `Additive` adds torque that is linear in its parameters; its regressor columns are computed from
the motion, by a formula or by integrating an internal state. `Signal` distorts what is measured of the machine.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, Literal, Self

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import quantities
from ident.dynamics.effects.c_code import CCode
from ident.dynamics.effects.formula import (
    LATEX,
    TEXT,
    Formula,
    arguments,
    sum_of_products,
    traced,
    unknown_arguments,
)
from recordings.recording import Floats
from recordings.rig import Rig

SignatureAxis = Literal["position", "velocity", "acceleration", "motor angle", "load", "time"]
Friction = Literal["c_v", "c_c"]
"""Viscous or Coulomb friction of the mechanism: the name of its parameters, followed by the number of the joint."""
Need = Literal["temperature", "no temperature", "both directions"]
"""What recordings must hold beyond motion and torque: the drives' temperature, or motion in both directions; or that
they must not hold the temperature, which would say more."""
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
    """Largest size that hardware usually has; a larger one is possible, but a warning names it."""
    searched: bool = True
    """False where only the `initial_guesses` are possible values, as for an index."""
    reduces_to: str | None = None
    """Effect that is left if this parameter is zero: one that the effect contains."""
    max_durations: float | None = None
    """Largest plausible size of a time constant, in durations of the longest training recording."""
    least: float = 0.0
    """Smallest plausible size of a time constant [s]."""
    min_use: float | None = None
    """Smallest plausible product of the inverse of a voltage with the largest recorded voltage, held-out recordings
    included: a limit that was never approached is not known."""

    @property
    def first_guess(self) -> float:
        """Where a search begins; 1 for what needs none."""
        return (self.initial_guesses or (1.0,))[0]

    @property
    def limit_text(self) -> str:
        """Its sign, where physics gives it one."""
        return f"{self.name} >= 0" if self.lower == 0 else f"{self.name} <= 0" if self.upper == 0 else ""

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


def _nothing(*_: object) -> None:
    """Nothing keeps an effect from being there or being seen."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Description that both kinds have in common."""

    linear: ClassVar[bool]
    """True if the torque is linear in the parameters."""

    parameters: tuple[Quantity, ...]
    """Per joint or for the whole robot. With all at zero there is no effect."""
    sentence: str
    """What the effect is, in one sentence for a technician."""
    symptom: str
    """How it shows in a recording."""
    causes: str
    """Usual causes."""
    remedy: str
    """Recommended action."""
    size: str = ""
    """How large it is, with its parameters and shapes in braces: "{a} at standstill", "{e:%}", "{N:n} per {turn}";
    {norm}: root of the sum of squares of its parameters on a joint; {largest}: the largest of them. Empty: a list."""
    record: str = ""
    """The motion that shows it."""
    equation: str = ""
    """As text; where it is not given, it follows from the formula and the limits of the parameters."""
    axis: SignatureAxis
    """Variable over which a plot of the residual shows the effect."""
    mechanisms: tuple[str, ...] = ("delta", "axes", "urdf")
    impossible: Callable[[Rig, int], str | None] = _nothing
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
    usual_travel: float = np.inf
    """Largest travel of a joint that usually has it [rad or m]."""
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
    guess_scale: Callable[[EffectInputs], Floats] | None = None
    """Return factors (dof,) of the initial guesses of its local parameters: the joints of one robot may differ by
    orders of magnitude."""
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
    """The effect as C, where that does not follow from a formula."""
    bodies: tuple[str, ...] | None = None
    """What its parameters add to in a simulation by rigid bodies, see `export.targets.mjcf`; None: it has no such
    element."""
    unobservable: Callable[[Rig, bool], str | None] = _nothing
    """Return why a recording of this rig cannot show the effect, or None. The flag is true if torque was recorded,
    not voltage."""

    _maker: Callable[[], "Effect"] | None = field(default=None, init=False, repr=False, compare=False)

    def made_by(self, maker: Callable[[], "Effect"]) -> Self:
        """Return the effect, which is pickled as the call of `maker` that gives it: its functions have no names."""
        object.__setattr__(self, "_maker", maker)
        return self

    def changed(self, **changes: Any) -> Self:
        """Return the effect with other values of some fields."""
        return replace(self, **changes).made_by(partial(replace, self, **changes))

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle by what makes the effect, or by its fields."""
        return (self._maker, ()) if self._maker else super().__reduce_ex__(protocol)

    @property
    def corrects_motion(self) -> bool:
        """Whether the motion or the lengths are not as recorded."""
        return False

    @property
    def depends_on_speed(self) -> bool:
        """Whether it is a formula of the speed or its direction, as laws of friction are."""
        return False

    @property
    def distorts_report(self) -> bool:
        """Whether the drives report another torque than that at the motors."""
        return False

    @property
    def latex(self) -> str | None:
        """The formula as LaTeX, without limits; None where there is none, or where words say more."""
        return None

    @staticmethod
    def _names(described: Sequence[Quantity]) -> list[str]:
        return [quantity.name for quantity in described]

    def errors(self) -> Iterator[str]:
        """Yield what its kind lacks in the description."""
        yield from ()

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
        if "no temperature" in self.needs and temperature_measured:
            return "Temperatures were recorded: with them it is temperature_friction."
        if not self.possible_joints(rig):
            return self.impossible(rig, 0)
        return self.unobservable(rig, torque_measured)


def _no_columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    raise NotImplementedError("an effect needs a formula or columns")


@dataclass(frozen=True, kw_only=True)
class Additive(Effect):
    """Additional torque that the drive must supply: the sum of parameter times column."""

    linear = True

    formula: Formula | None = None
    """Column of each of the c parameters, of the quantities that `formula.py` lists and of shapes. It depends neither
    on the parameters nor on any measurement but the motion."""
    on_arm: bool = False
    """True if the torque acts on the arm, so that springs and backlash between motor and arm transmit it."""
    columns: Callable[[EffectInputs, Shapes], Floats] = field(default=_no_columns)
    """Torque per unit of each parameter (n, dof, c); NaN where the motion is NaN. Where it is not given, it follows
    from the formula."""

    def __post_init__(self) -> None:
        if self.formula is None:
            return
        if self.columns is _no_columns:
            object.__setattr__(self, "columns", partial(quantities.columns, self.formula))
        if not self.equation:
            friction = {"c_v": " in place of c_v v", "c_c": " in place of c_c sgn v", None: ""}[self.replaces]
            limits = [f", {quantity.limit_text}" for quantity in self.parameters if quantity.limit_text]
            object.__setattr__(self, "equation", "".join([TEXT(self.expression), friction, *limits]))

    @property
    def depends_on_speed(self) -> bool:
        """See `Effect`."""
        return self.formula is not None and not {"qd", "direction"}.isdisjoint(arguments(self.formula))

    @property
    def latex(self) -> str | None:
        """See `Effect`."""
        return None if self.formula is None else LATEX(self.expression)

    def errors(self) -> Iterator[str]:
        """See `Effect`."""
        if self.columns is _no_columns:
            yield "formula: a function of named quantities expected, or columns; none found"
        if self.formula is not None:
            yield from unknown_arguments("formula", self.formula, [*quantities.QUANTITIES, *self._names(self.shapes)])

    @property
    def expression(self) -> Any:
        """What the formula adds: the sum of parameters times columns."""
        assert self.formula is not None
        return sum_of_products([quantity.name for quantity in self.parameters], traced(self.formula))


@dataclass(frozen=True, kw_only=True)
class Signal(Effect):
    """A distortion of the measurement, nonlinear in its parameters, each of which has `initial_guesses`."""

    linear = False

    reading: Formula | None = None
    """What the encoder reads, of the true position q, parameters and shapes."""
    rig: Callable[[Rig, Values], Rig] | None = None
    """Compute the true rig from the one in the file."""
    report: Callable[[Floats, EffectInputs, Values], Floats] | None = None
    """Compute, from the true torque (n, dof), the torque (n, dof) that the rig's map gives for what is reported."""
    perturbed_report: Callable[[Floats, EffectInputs, Values], Floats] | None = None
    """Compute the report with an error of one standard deviation in what the equation idealizes, such as the instant
    of an impact, which widens the intervals; None: there is no such error."""
    pointwise: bool = True
    """False if the report is a linear filter over time, as of a delay, for torque (n, dof, ...)."""
    offset: bool = False
    """True if the report is the true torque plus a torque that does not depend on it."""

    def __post_init__(self) -> None:
        if self.reading is not None and not self.equation:
            object.__setattr__(self, "equation", f"measured q = {TEXT(traced(self.reading)[0])}")

    def errors(self) -> Iterator[str]:
        """See `Effect`."""
        if self.reading is not None:
            known = ["q", *self._names(self.parameters), *self._names(self.shapes)]
            yield from unknown_arguments("reading", self.reading, known)

    @property
    def latex(self) -> str | None:
        """See `Effect`."""
        return None if self.reading is None else rf"q_\mathrm{{measured}} = {LATEX(traced(self.reading)[0])}"

    @property
    def corrects_motion(self) -> bool:
        """See `Effect`."""
        return self.reading is not None or self.rig is not None

    @property
    def distorts_report(self) -> bool:
        """See `Effect`."""
        return self.report is not None and not self.offset
