"""A mechanism with additive effects whose shapes are given, for motions that nobody has recorded yet."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import GRAVITY, EffectInputs
from ident.dynamics.effects.base import Additive, Effect, Shapes
from ident.dynamics.effects.library import load
from ident.dynamics.mechanisms import Mechanism, Parameter
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig

_RATE = 500.0
"""At which motions are taken to be sampled where nobody says [Hz]; only effects that remember look at it."""
_SOME = 40.0
"""For a shape that is never searched blindly, such as a number of periods per turn."""


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
        view = inputs_of(self.rig, self.base, motion, nominal_parameters(self.rig, self.base))
        return np.concatenate([self.base.regressor(motion), additive_columns(self.effect, view)], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        return self.base.nominal_torque(motion)


def with_rig(mechanism: Mechanism, rig: Rig) -> Mechanism:
    """The same `mechanism` for another `rig`."""
    if isinstance(mechanism, _With):
        return replace(mechanism, base=with_rig(mechanism.base, rig), rig=rig)
    return mechanisms.create(rig)


def additive_columns(effect: Additive, inputs: EffectInputs) -> Floats:
    """Torque (n, dof, owners * c) per unit of each coefficient of the `effect` on every joint, joint by joint."""
    made = effect.columns(inputs, middle_shapes(effect))
    if effect.whole_robot:
        return made
    n, dof, c = made.shape
    own = np.zeros((n, dof, dof, c))
    joint = np.arange(dof)
    own[:, joint, joint] = made
    return own.reshape(n, dof, dof * c)


def middle_shapes(effect: Effect) -> Shapes:
    """The middle one of the shapes at which a search for the `effect` begins."""
    return {one.name: one.initial_guesses[len(one.initial_guesses) // 2] if one.initial_guesses else _SOME for one in effect.shapes}


def nominal_parameters(rig: Rig, mechanism: Mechanism) -> Floats:
    """(k,) parameters of the `mechanism` with the masses of the rig file, half of each forearm's at either end.

    0 for those that the rig file does not know: friction, and everything of independent axes.
    """
    if rig.mechanism != "delta":
        return np.zeros(len(mechanism.parameters))
    nominal, arm = rig.nominal, rig.geometry.L1
    inertia = nominal.motor_inertia + nominal.I_L1 + nominal.m_a * nominal.L1c**2 + nominal.m_d / 2 * arm**2
    known = {f"I_{joint}": inertia for joint in (1, 2, 3)} | {
        "m_p": nominal.m_p + 3 * nominal.m_d / 2,
        "T_g": GRAVITY * (nominal.m_a * nominal.L1c + nominal.m_d / 2 * arm),
    }
    return np.array([known.get(parameter.name, 0.0) for parameter in mechanism.parameters])


def inputs_of(rig: Rig, mechanism: Mechanism, motion: Motion, parameters: Floats, rate: float = _RATE) -> EffectInputs:
    """What effects see of a `motion` that nobody has recorded, at `rate` [Hz].

    load: (k,) parameters of the `mechanism`.
    """
    rigid = np.array([0.0 if parameter.friction else 1.0 for parameter in mechanism.parameters]) * parameters

    def load_at(other: Motion) -> Floats:
        torque: Floats = mechanism.regressor(other) @ rigid
        return torque

    known = {one.name: float(value) for one, value in zip(mechanism.parameters, parameters, strict=True)}
    known["m_d"] = sum(value for name, value in known.items() if name.endswith(".m_d"))
    return EffectInputs(rig, rate, np.arange(len(motion.position)) / rate, motion, load_at, rate / 2, known)
