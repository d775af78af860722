"""Physical effects that the base model of a mechanism does not know. One effect is one file here, named as users
type it; its module holds `effect`, a description that says all there is to know about it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from ident import discovery
from ident.mechanisms import Mechanism, Parameter
from ident.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig

Signature = Literal["position", "velocity", "acceleration", "motor angle", "load", "time"]


@dataclass(frozen=True)
class Effect:
    """An additive effect: further torque, linear in coefficients of which every joint has its own."""

    sentence: str
    """What it is, for a person."""
    equation: str
    """Of the torque that the amplifier must give in addition."""
    coefficients: tuple[Parameter, ...]
    """c of them per joint. In a unit, {effort} stands for N m or N, {position} for rad or m."""
    axis: Signature
    """What the torque changes with: where to look for the effect."""
    causes: str
    """What usually causes it."""
    remedy: str
    """What to do about it."""
    columns: Callable[[Motion], Floats]
    """Torque per unit of each coefficient (n, dof, c); NaN where the motion is."""


def load(name: str) -> Effect:
    """The effect `name`. Raises BadInput where there is none."""
    return cast(Effect, discovery.load("effects", name).effect)


def with_effects(mechanism: Mechanism, names: Sequence[str], rig: Rig) -> Mechanism:
    """`mechanism` with the effects `names` on every joint, as one mechanism.

    Raises:
        BadInput: there is no such effect, or it is named twice.
    """
    for name in names:
        if names.count(name) > 1:
            raise BadInput(f"every effect once expected, '{name}' found twice; leave one out")
        mechanism = _Extended(mechanism, name, load(name), rig)
    return mechanism


@dataclass(frozen=True)
class _Extended:
    """A mechanism and one effect: columns and parameters joint by joint behind those of the mechanism."""

    base: Mechanism
    name: str
    effect: Effect
    rig: Rig

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        units = zip(self.rig.effort_units, self.rig.position_units, strict=True)
        own = [
            Parameter(
                f"{self.name}.{coefficient.name}{joint}",
                coefficient.unit.format(effort=effort, position=position),
                f"{coefficient.meaning}, joint {joint}",
                coefficient.nonnegative,
            )
            for joint, (effort, position) in enumerate(units, start=1)
            for coefficient in self.effect.coefficients
        ]
        return *self.base.parameters, *own

    @property
    def pointwise(self) -> bool:
        return self.base.pointwise

    def regressor(self, motion: Motion) -> Floats:
        base, shapes = self.base.regressor(motion), self.effect.columns(motion)
        n, dof, c = shapes.shape
        own = np.zeros((n, dof, dof, c))
        joint = np.arange(dof)
        own[:, joint, joint] = shapes
        return np.concatenate([base, own.reshape(n, dof, dof * c)], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        return self.base.nominal_torque(motion)
