"""A mechanism with additive effects whose shapes are given, for motions that nobody has recorded yet."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident import mechanisms
from ident.effects import Additive, load
from ident.mechanisms import Mechanism, Parameter
from ident.motion import Motion
from ident.view import GRAVITY, Rate, View
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig

_RATE = 500.0
"""At which motions are taken to be sampled [Hz]; only effects that remember look at it."""
_STEPS: dict[Rate, float] = {"position": 1e-5, "acceleration": 1.0}
"""Of differences."""


def with_effects(rig: Rig, names: Sequence[str]) -> Mechanism:
    """The mechanism of `rig` with the effects `names` on every joint, each of the first of the shapes it may have.

    Raises:
        BadInput: an effect is named twice, is not one of this mechanism, or is none that adds a torque.
    """
    mechanism = mechanisms.create(rig)
    for name in names:
        if names.count(name) > 1:
            raise BadInput(f"every effect once expected, '{name}' found twice; leave one out")
        effect = load(name)
        if not isinstance(effect, Additive) or rig.mechanism not in effect.mechanisms or effect.axis == "time":
            raise BadInput(
                f"effect {name}: one that adds torque to a {rig.mechanism}, always alike, expected; leave it out"
            )
        mechanism = _With(mechanism, name, effect, rig)
    return mechanism


@dataclass(frozen=True)
class _With:
    """A mechanism and one effect: columns and parameters behind those of the mechanism."""

    base: Mechanism
    name: str
    effect: Additive
    rig: Rig

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        owners = [""] if self.effect.whole_robot else [str(joint + 1) for joint in range(self.rig.dof)]
        own = [
            Parameter(
                f"{self.name}.{one.name}{owner}",
                one.unit.format(effort=self.rig.effort_units[0], position=self.rig.position_units[0]),
                one.meaning,
            )
            for owner in owners
            for one in self.effect.coefficients
        ]
        return *self.base.parameters, *own

    @property
    def pointwise(self) -> bool:
        return False

    def regressor(self, motion: Motion) -> Floats:
        base, shapes = (
            self.base.regressor(motion),
            self.effect.columns(view_of(self.rig, self.base, motion), self._shapes()),
        )
        n, dof, c = shapes.shape
        if self.effect.whole_robot:
            return np.concatenate([base, shapes], axis=2)
        own = np.zeros((n, dof, dof, c))
        joint = np.arange(dof)
        own[:, joint, joint] = shapes
        return np.concatenate([base, own.reshape(n, dof, dof * c)], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        return self.base.nominal_torque(motion)

    def _shapes(self) -> dict[str, float]:
        return {shape.name: shape.starts[len(shape.starts) // 2] for shape in self.effect.shapes if shape.starts}


def view_of(rig: Rig, mechanism: Mechanism, motion: Motion) -> View:
    """What effects see of a `motion` that nobody has recorded: with the load of the manufacturer's model, or none."""
    mass = rig.nominal
    known = {"m_p": mass.m_p + 3 * mass.m_d, "T_g": mass.m_a * mass.L1c * GRAVITY, "m_d": 0.0}

    def load_at(other: Motion) -> Floats:
        torque = mechanism.nominal_torque(other)
        return np.zeros_like(other.position) if torque is None else torque

    def slope(name: Rate) -> Floats:
        here, step = getattr(motion, name), _STEPS[name]
        moved = [replace(motion, **{name: here + step * unit}) for unit in np.eye(rig.dof)]
        return np.stack([(load_at(one) - load_at(motion)) / step for one in moved], axis=2)

    time = np.arange(len(motion.position)) / _RATE
    return View(rig, _RATE, time, motion, load_at, slope, known)
