"""What a hidden effect is, and where all of them are found.

One effect is one file in `drivers/simulated/effects/`, named as in the list of effects, holding one subclass of
`Effect`: its parameters as fields, and its physics in the hooks that it overrides. Hooks are pure functions of the
machine's state, so that effects add up. These are laws of nature, written independently of the models in `ident`.
"""

import importlib
import pkgutil
from functools import cache
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from drivers.simulated.config import EffectSpec, Joint
from drivers.simulated.model_xml import Coupling
from recordings.config import Section, validated
from recordings.errors import BadInput


class Effect(Section):
    """Base of all hidden effects; as it stands, one that does nothing.

    The first field that a subclass adds is its *strength*: the effect grows with it and vanishes at zero. It acts on
    each of `joints` alike, or on the whole robot.
    """

    whole_robot: ClassVar[bool] = False
    """True where the effect has no joints of its own."""

    joints: tuple[Joint, ...] = (1, 2, 3)

    @classmethod
    def name(cls) -> str:
        """Name in the list of effects: that of its file."""
        return cls.__module__.rpartition(".")[2]

    @model_validator(mode="after")
    def _joints_make_sense(self) -> Self:
        if self.whole_robot and self.joints != (1, 2, 3):
            raise ValueError(f"it acts on the whole robot; joints {list(self.joints)} found, leave them out")
        if not self.joints or len(set(self.joints)) < len(self.joints):
            raise ValueError(f"joints each named once expected, {list(self.joints)} found")
        return self

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        """Parameters as they might be found on a real robot; of the strength only the sign matters."""
        return {}

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

    def spec(self) -> EffectSpec:
        """What a sim file would say."""
        return EffectSpec(name=self.name(), joints=self.joints, parameters=self.model_dump(exclude={"joints"}))

    def torque(self, q: float, v: float) -> float:
        """Torque that the motor must give in addition [N m], at its angle q [rad] and speed v [rad/s]."""
        return 0.0

    def friction(self, v: float, rigid: float) -> float:
        """Further level of dry friction [N m], at speed v [rad/s] and torque `rigid` [N m] on the rigid robot."""
        return 0.0

    def added_mass(self, t: float) -> float:
        """Further mass on the platform [kg], at time t [s]."""
        return 0.0

    def tilt(self) -> tuple[float, float]:
        """Horizontal components of gravity [m/s^2]."""
        return 0.0, 0.0

    def lag(self) -> float:
        """Time by which the torque follows the voltage [s]."""
        return 0.0

    def couplings(self) -> tuple[Coupling, ...]:
        """What stands between motor and arm, in series."""
        return ()


def parameter(default: float, unit: str, meaning: str, *, ge: float | None = None, le: float) -> Any:
    """A field of an effect, with unit and bounds; `le` of the strength is the greatest that can be drawn."""
    return Field(default=default, description=meaning, ge=ge, le=le, json_schema_extra={"unit": unit})


@cache
def discover() -> dict[str, type[Effect]]:
    """All effects by name."""
    package = importlib.import_module("drivers.simulated.effects")
    modules = [
        importlib.import_module(f"{package.__name__}.{found.name}")
        for found in pkgutil.iter_modules(package.__path__)
    ]
    found: dict[str, type[Effect]] = {}
    for module in modules:
        (effect,) = (
            value
            for value in vars(module).values()
            if isinstance(value, type) and issubclass(value, Effect) and value.__module__ == module.__name__
        )
        found[effect.name()] = effect
    return found


def build(spec: EffectSpec) -> Effect:
    """The effect that a sim file asks for.

    Raises:
        BadInput: no such effect, an unknown parameter, or one out of its bounds.
    """
    if spec.name not in discover():
        raise BadInput(f"one of the effects {', '.join(sorted(discover()))} expected, '{spec.name}' found")
    content = {"joints": spec.joints, **spec.parameters}
    return validated(content, discover()[spec.name], f"effect {spec.name}")


def overrides(effect: Effect, hook: str) -> bool:
    """Whether the effect has something of its own to say there."""
    return getattr(type(effect), hook) is not getattr(Effect, hook)
