"""What a hidden effect is, and where all of them are found.

One effect is one file holding one subclass of `Effect`: its parameters as fields, and its physics in the hooks it
overrides. Those in `drivers/simulated/effects/` are named as in the list of effects; those in
`drivers/simulated/out_of_library/` stand in no library, so that no model can name them. Hooks are pure functions of the
machine's state, so that effects add up. These are laws of nature, written independently of the models in `ident`.
"""

import importlib
import pkgutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from drivers.simulated.config import EffectSpec, Joint
from drivers.simulated.model_xml import Arm, Coupling
from recordings.config import Section, validated
from recordings.errors import BadInput
from recordings.rig import Geometry

Variable = Literal["position", "velocity", "acceleration", "load", "time", "frequency"]
_FOLDERS = ("drivers.simulated.effects", "drivers.simulated.out_of_library")


@dataclass(slots=True)
class JointState:
    """The machine at the beginning of a step, as the hooks see it; lists have one number per joint."""

    t: float = 0.0
    """[s]."""
    q: list[float] = field(default_factory=list)
    """True angles of the motors [rad]."""
    v: list[float] = field(default_factory=list)
    """Their speeds [rad/s]."""
    a: Sequence[float] = (0.0, 0.0, 0.0)
    """Their accelerations in the step before [rad/s^2]; kept up only if an effect's `variables` name it."""
    load: Sequence[float] = (0.0, 0.0, 0.0)
    """Torque that went through friction to the rigid robot in the step before [N m]; likewise."""


class HiddenEffect(Section):
    """Base of all hidden effects; as it stands, one that does nothing.

    The first field that a subclass adds is its *strength*: the effect grows with it and vanishes at zero. It acts on
    each of `joints` alike, on what lies between them, or on the whole robot.
    """

    variables: ClassVar[tuple[Variable, ...]] = ()
    """What it depends on."""
    whole_robot: ClassVar[bool] = False
    """True where the effect has no joints of its own."""
    between_joints: ClassVar[bool] = False
    """True where it acts between its joints, of which it then needs two at least."""
    cycles: ClassVar[int] = 1
    """Repetitions of a motion that it takes to see how large it is."""

    joints: tuple[Joint, ...] = (1, 2, 3)

    @classmethod
    def name(cls) -> str:
        """Name in the list of effects: that of its file."""
        return cls.__module__.rpartition(".")[2]

    @classmethod
    def in_library(cls) -> bool:
        """True where it is one of the list of effects."""
        return cls.__module__.startswith(_FOLDERS[0])

    @model_validator(mode="after")
    def _joints_make_sense(self) -> Self:
        if self.whole_robot and self.joints != (1, 2, 3):
            raise ValueError(f"it acts on the whole robot; joints {list(self.joints)} found, leave them out")
        if not self.joints or len(set(self.joints)) < len(self.joints):
            raise ValueError(f"joints each named once expected, {list(self.joints)} found")
        if self.between_joints and len(self.joints) < 2:
            raise ValueError(f"it acts between joints; two or three expected, {list(self.joints)} found")
        return self

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        """Parameters as they might be found on a real robot; of the strength only the sign matters."""
        return {}

    @classmethod
    def draw_joints(cls, rng: np.random.Generator) -> tuple[int, ...]:
        """Joints on which it might be found."""
        if cls.whole_robot:
            return 1, 2, 3
        return draw_joints(rng, 2 if cls.between_joints else int(rng.integers(1, 4)))

    @classmethod
    def strength(cls) -> str:
        """Name of the parameter that scales the effect."""
        return next(field for field in cls.model_fields if field != "joints")

    @classmethod
    def largest(cls) -> float:
        """The greatest strength that is still the same robot."""
        bounds = cls.model_fields[cls.strength()].metadata
        return float(next(bound.le for bound in bounds if hasattr(bound, "le")))

    def scaled(self, strength: float) -> Self:
        """The same effect with another strength."""
        return self.model_copy(update={self.strength(): strength})

    def at(self, t: float) -> Self:
        """The same effect, happening at the time t [s] if it happens at one."""
        return self

    def depends_on(self) -> tuple[str, ...]:
        """The variables that it depends on, and the joints on whose motion that of other joints depends."""
        others = tuple(f"joint_{joint}" for joint in self.joints) if self.between_joints else ()
        return (*self.variables, *others)

    def reads_state(self) -> bool:
        """Whether it has hooks that take the machine's state."""
        return overrides(self, "torque") or overrides(self, "friction")

    def spec(self) -> EffectSpec:
        """What a sim file would say."""
        return EffectSpec(name=self.name(), joints=self.joints, parameters=self.model_dump(exclude={"joints"}))

    # Hooks: torques and friction of the joint i (from 0)

    def torque(self, i: int, now: JointState) -> float:
        """Torque that the motor must give in addition [N m]."""
        return 0.0

    def friction(self, i: int, now: JointState) -> float:
        """Further level of dry friction [N m]."""
        return 0.0

    def bristle(self) -> float:
        """Displacement over which dry friction builds up [rad]."""
        return 0.0

    # Hooks: the mechanism

    def added_mass(self, t: float) -> float:
        """Further mass on the platform [kg], at time t [s]."""
        return 0.0

    def drag(self, speed: float) -> float:
        """Force against the platform's motion at its speed [m/s], over that speed [N s/m]."""
        return 0.0

    def tilt(self) -> tuple[float, float]:
        """Horizontal components of gravity [m/s^2]."""
        return 0.0, 0.0

    def geometry(self, geometry: Geometry) -> Geometry:
        """What the lengths really are."""
        return geometry

    def arm(self, arm: Arm) -> Arm:
        """What the arm really is."""
        return arm

    def couplings(self) -> tuple[Coupling, ...]:
        """What stands between motor and arm, in series."""
        return ()

    # Hooks: drive and sensors

    def lag(self) -> float:
        """Time by which the torque follows the voltage [s]."""
        return 0.0

    def amplify(self, volts: float) -> float:
        """Voltage across the motor for the commanded one [V]."""
        return volts

    def back_emf(self) -> float:
        """Voltage reported in addition, per speed [V s/rad]."""
        return 0.0

    def gain(self) -> float:
        """By which factor the torque gain differs from the rig's."""
        return 1.0

    def exponent(self) -> float:
        """By how much the exponent of the torque map differs from the rig's."""
        return 0.0

    def encoder(self, q: float) -> tuple[float, float]:
        """By how much the encoder is wrong at the angle q [rad], and the derivative of that."""
        return 0.0, 0.0


def parameter(default: float, unit: str, meaning: str, *, ge: float | None = None, le: float) -> Any:
    """A field of an effect, with unit and bounds; `le` of the strength is the greatest that can be drawn."""
    return Field(default=default, description=meaning, ge=ge, le=le, json_schema_extra={"unit": unit})


def draw_joints(rng: np.random.Generator, count: int) -> tuple[int, ...]:
    """So many of the joints."""
    return tuple(sorted((rng.permutation(3)[:count] + 1).tolist()))


def draw_sign(rng: np.random.Generator, strength: float) -> float:
    """The strength or its opposite."""
    return float(rng.choice((-strength, strength)))


@cache
def discover() -> dict[str, type[HiddenEffect]]:
    """All effects by name, those of the library and those outside."""
    kinds = [kind for folder in _FOLDERS for kind in _kinds(folder)]
    return {kind.name(): kind for kind in kinds}


def library() -> tuple[str, ...]:
    """Names of the effects that stand in the list of effects, in alphabetical order."""
    return tuple(sorted(name for name, kind in discover().items() if kind.in_library()))


def out_of_library() -> tuple[str, ...]:
    """Names of the others, in alphabetical order."""
    return tuple(sorted(set(discover()) - set(library())))


def _kinds(folder: str) -> list[type[HiddenEffect]]:
    package = importlib.import_module(folder)
    modules = [importlib.import_module(f"{folder}.{found.name}") for found in pkgutil.iter_modules(package.__path__)]
    kinds = []
    for module in modules:
        (kind,) = (
            value
            for value in vars(module).values()
            if isinstance(value, type) and issubclass(value, HiddenEffect) and value.__module__ == module.__name__
        )
        kinds.append(kind)
    return kinds


def build(spec: EffectSpec) -> HiddenEffect:
    """The effect that a sim file asks for.

    Raises:
        BadInput: no such effect, an unknown parameter, or one out of its bounds.
    """
    if spec.name not in discover():
        raise BadInput(f"one of the effects {', '.join(sorted(discover()))} expected, '{spec.name}' found")
    content = {"joints": spec.joints, **spec.parameters}
    return validated(content, discover()[spec.name], f"effect {spec.name}")


def overrides(effect: HiddenEffect, hook: str) -> bool:
    """Whether the effect has something of its own to say there."""
    return getattr(type(effect), hook) is not getattr(HiddenEffect, hook)
