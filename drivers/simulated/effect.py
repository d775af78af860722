"""Base class and discovery of the hidden effects.

One file defines one effect, as a subclass of `HiddenEffect`: its parameters are fields, its physics is in the hooks
it overrides. The effects in `drivers/simulated/effects/` are named as in the list of effects; those in
`drivers/simulated/out_of_library/` are in no library, so that no model can name them. Hooks are pure functions of the
machine's state, so that effects add up. The laws are written independently of the models in `ident`.
"""

import importlib
import math
import pkgutil
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from drivers.simulated.config import EffectSpec, Joint
from drivers.simulated.model_xml import Arm, ShaftCoupling
from recordings.config import ConfigSection, validated
from recordings.errors import BadInput
from recordings.rig import Geometry

Variable = Literal["position", "velocity", "acceleration", "load", "time", "frequency"]
_FOLDERS = ("drivers.simulated.effects", "drivers.simulated.out_of_library")


@dataclass(slots=True)
class JointState:
    """State of the joints at the beginning of a step, argument of the hooks; lists have one number per joint."""

    t: float = 0.0
    """[s]."""
    q: list[float] = field(default_factory=list)
    """True angles of the motors [rad]."""
    v: list[float] = field(default_factory=list)
    """Their speeds [rad/s]."""
    a: Sequence[float] = (0.0, 0.0, 0.0)
    """Their accelerations in the previous step [rad/s^2]; updated only if an effect's `variables` name it."""
    load: Sequence[float] = (0.0, 0.0, 0.0)
    """Torque transmitted to the rigid robot, after friction, in the previous step [N m]; likewise."""


class HiddenEffect(ConfigSection):
    """Base class of all hidden effects; on its own it has no effect.

    The first field that a subclass adds is its *strength*: the effect grows with it and vanishes at zero. It acts
    equally on each of `joints`, between them, or on the whole robot.
    """

    variables: ClassVar[tuple[Variable, ...]] = ()
    """Variables that the effect depends on."""
    whole_robot: ClassVar[bool] = False
    """True if the effect acts on the whole robot rather than on joints."""
    between_joints: ClassVar[bool] = False
    """True if the effect acts between its joints; it then needs at least two."""
    single_joint: ClassVar[bool] = False
    """True if the effect is drawn for one joint only: it is a difference between joints."""
    drawn_by_seed: ClassVar[bool] = True
    """False for effects that came later: a seed draws the same effect in every version."""
    contains: ClassVar[tuple[str, ...]] = ()
    """Effects that are special cases of this one: its size is what they cannot absorb either."""
    cycles: ClassVar[int] = 1
    """Number of repetitions of a motion needed to measure its size."""

    joints: tuple[Joint, ...] = (1, 2, 3)

    @classmethod
    def name(cls) -> str:
        """Name in the list of effects: the name of its file."""
        return cls.__module__.rpartition(".")[2]

    def contained(self) -> list["HiddenEffect"]:
        """The effects that it contains, on each of its joints alone."""
        return [discover()[name](joints=(joint,)) for name in self.contains for joint in self.joints]

    @classmethod
    def in_library(cls) -> bool:
        """True if the effect is in the list of effects."""
        return cls.__module__.startswith(_FOLDERS[0])

    @model_validator(mode="after")
    def _check_joints(self) -> Self:
        if self.whole_robot and self.joints != (1, 2, 3):
            raise ValueError(f"it acts on the whole robot; joints {list(self.joints)} found, leave them out")
        if not self.joints or len(set(self.joints)) < len(self.joints):
            raise ValueError(f"joints each named once expected, {list(self.joints)} found")
        if self.between_joints and len(self.joints) < 2:
            raise ValueError(f"it acts between joints; two or three expected, {list(self.joints)} found")
        return self

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        """Draw realistic parameters; the others have their defaults.

        Of the strength only the sign matters; it is drawn if it may be negative.
        """
        strength = cls.model_fields[cls.strength()]
        signed = any(bound.ge < 0 for bound in strength.metadata if hasattr(bound, "ge"))
        sign = {cls.strength(): float(rng.choice((-strength.default, strength.default)))} if signed else {}
        extras: dict[str, Any] = {name: field.json_schema_extra or {} for name, field in cls.model_fields.items()}
        return sign | {name: rng.uniform(*extra["drawn"]) for name, extra in extras.items() if extra.get("drawn")}

    @classmethod
    def draw_joints(cls, rng: np.random.Generator) -> tuple[int, ...]:
        """Draw the joints of the effect."""
        if cls.whole_robot:
            return 1, 2, 3
        count = 2 if cls.between_joints else 1 if cls.single_joint else int(rng.integers(1, 4))
        return tuple(sorted((rng.permutation(3)[:count] + 1).tolist()))

    @classmethod
    def strength(cls) -> str:
        """Name of the parameter that scales the effect."""
        return next(field for field in cls.model_fields if field != "joints")

    @classmethod
    def largest(cls) -> float:
        """Upper bound of the strength."""
        bounds = cls.model_fields[cls.strength()].metadata
        return float(next(bound.le for bound in bounds if hasattr(bound, "le")))

    def scaled(self, strength: float) -> Self:
        """The same effect with another strength."""
        return self.model_copy(update={self.strength(): strength})

    def at(self, t: float) -> Self:
        """The same effect; if it happens at an instant, then at the time t [s]."""
        return self

    def depends_on(self) -> tuple[str, ...]:
        """Variables that the effect depends on, and the joints that it couples."""
        coupled = tuple(f"joint_{joint}" for joint in self.joints) if self.between_joints else ()
        return (*self.variables, *coupled)

    def reads_state(self) -> bool:
        """Whether the effect has hooks with the machine's state as argument."""
        return bool(overriding((self,), "torque") or overriding((self,), "friction"))

    def spec(self) -> EffectSpec:
        """The effect as in a sim file."""
        return EffectSpec(name=self.name(), joints=self.joints, parameters=self.model_dump(exclude={"joints"}))

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        """The values of the parameters by which the list of effects describes it on `joint` (from 1), by their names.

        coulomb: dry friction of the joint [N m], NaN where it is not known.
        found: what a model has, such as the ends of a curve; those of a joint have its number behind their names.
        """
        return self.model_dump(exclude={"joints"})

    # Hooks: torque and friction of the joint i (from 0)

    def torque(self, i: int, state: JointState) -> float:
        """Additional torque required from the motor [N m]."""
        return 0.0

    def friction(self, i: int, state: JointState) -> float:
        """Additional level of dry friction [N m]."""
        return 0.0

    def viscous_share(self) -> float:
        """Share of the viscous friction that remains."""
        return 1.0

    def bristle(self) -> float:
        """Displacement over which dry friction builds up [rad]."""
        return 0.0

    def warming(self) -> tuple[float, float, float] | None:
        """Share by which friction falls at a power of it [W], this power, and the time constant [s]; or None."""
        return None

    # Hooks: the mechanism

    def ball_friction(self) -> tuple[float, float]:
        """Dry [N m] and viscous [N m s/rad] friction of the balls at each end of a rod."""
        return 0.0, 0.0

    def added_mass(self, t: float) -> float:
        """Additional mass on the platform [kg] at time t [s]."""
        return 0.0

    def drag(self, speed: float) -> float:
        """Force opposing the platform's motion divided by its speed [N s/m], at that speed [m/s]."""
        return 0.0

    def tilt(self) -> tuple[float, float]:
        """Horizontal components of gravity [m/s^2]."""
        return 0.0, 0.0

    def geometry(self, geometry: Geometry) -> Geometry:
        """True lengths of the robot."""
        return geometry

    def arm(self, arm: Arm) -> Arm:
        """True mass properties of the arm."""
        return arm

    def couplings(self) -> tuple[ShaftCoupling, ...]:
        """Couplings between motor and arm, in series."""
        return ()

    # Hooks: drive and sensors

    def lag(self) -> float:
        """Delay from voltage to torque [s]."""
        return 0.0

    def amplify(self, volts: float) -> float:
        """Motor voltage for a commanded voltage [V]."""
        return volts

    def back_emf(self) -> float:
        """Additional reported voltage per joint speed [V s/rad]."""
        return 0.0

    def gain(self) -> float:
        """Torque gain divided by the rig's."""
        return 1.0

    def exponent(self) -> float:
        """Exponent of the torque map minus the rig's."""
        return 0.0

    def encoder(self, q: float) -> tuple[float, float]:
        """Encoder error at the angle q [rad], and its derivative with respect to q."""
        return 0.0, 0.0


def sine_and_cosine(amplitude: float, phase: float) -> dict[str, float]:
    """Parameters a and b of a wave: amplitude sin(x + phase) = a sin x + b cos x."""
    return {"a": amplitude * math.cos(phase), "b": amplitude * math.sin(phase)}


def at_knots(name: str, joint: int, found: Mapping[str, float], curve: Callable[[float], float]) -> dict[str, float]:
    """Values of a `curve` of the angle at the knots of a spline that was found on a `joint`: NAME_1, NAME_2, ..."""
    knots = sum(bool(re.fullmatch(rf"{name}_\d+{joint}", each)) for each in found)
    places = np.linspace(found.get(f"low{joint}", 0.0), found.get(f"high{joint}", 0.0), knots).tolist()
    return {f"{name}_{number}": curve(place) for number, place in enumerate(places, start=1)}


def parameter(
    default: float,
    unit: str,
    meaning: str,
    *,
    ge: float | None = None,
    le: float,
    drawn: tuple[float, float] | None = None,
) -> Any:
    """Define a field of an effect, with unit, bounds, and the range that realistic values are drawn from.

    `le` of the strength is the greatest that can be drawn.
    """
    extra: Any = {"unit": unit, "drawn": drawn}
    return Field(default=default, description=meaning, ge=ge, le=le, json_schema_extra=extra)


@cache
def discover() -> dict[str, type[HiddenEffect]]:
    """All effects by name, in the library and out of it."""
    for folder in _FOLDERS:
        for file in pkgutil.iter_modules(importlib.import_module(folder).__path__, f"{folder}."):
            importlib.import_module(file.name)
    # Those of other folders are the tests' own.
    return {kind.name(): kind for kind in HiddenEffect.__subclasses__() if kind.__module__.startswith(_FOLDERS)}


def library() -> tuple[str, ...]:
    """Names of the effects in the list of effects, in alphabetical order."""
    return tuple(sorted(name for name, kind in discover().items() if kind.in_library()))


def out_of_library() -> tuple[str, ...]:
    """Names of the effects out of the library, in alphabetical order."""
    return tuple(sorted(set(discover()) - set(library())))


def build(spec: EffectSpec) -> HiddenEffect:
    """Build the effect of a sim file.

    Raises:
        BadInput: no such effect, an unknown parameter, or one out of its bounds.
    """
    if spec.name not in discover():
        raise BadInput(f"one of the effects {', '.join(sorted(discover()))} expected, '{spec.name}' found")
    content = {"joints": spec.joints, **spec.parameters}
    return validated(content, discover()[spec.name], f"effect {spec.name}")


def overriding(effects: Sequence[HiddenEffect], hook: str) -> list[Any]:
    """The hook of each of the effects that override it."""
    base = getattr(HiddenEffect, hook)
    return [getattr(effect, hook) for effect in effects if getattr(type(effect), hook) is not base]
