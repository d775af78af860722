"""A mechanism with additive effects of given shapes, for motions that have not been recorded."""

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
"""Default sample rate of motions [Hz]; only effects with memory depend on it."""
_DEFAULT_SHAPE = 40.0
"""Value of a shape without initial guesses, such as a number of periods per turn."""


def with_effects(rig: Rig, names: Sequence[str]) -> Mechanism:
    """Return the mechanism of `rig` with the effects `names` on every joint.

    Raises:
        BadInput: an effect is named twice, does not exist for this mechanism, or does not add a torque.
    """
    mechanism = mechanisms.create(rig)
    for name in names:
        if names.count(name) > 1:
            raise BadInput(f"every effect once expected, '{name}' found twice; remove one")
        effect = load(name)
        if not isinstance(effect, Additive) or rig.mechanism not in effect.mechanisms or effect.axis == "time":
            raise BadInput(
                f"effect {name}: an effect expected that adds torque to a {rig.mechanism} and does not change with "
                "time; remove it"
            )
        mechanism = _MechanismWithEffect(mechanism, name, effect, rig)
    return mechanism


@dataclass(frozen=True)
class _MechanismWithEffect:
    """A mechanism and one effect, whose columns and parameters follow those of the mechanism."""

    base: Mechanism
    name: str
    effect: Additive
    rig: Rig

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        suffixes = [""] if self.effect.whole_robot else [str(joint + 1) for joint in range(self.rig.dof)]
        effect_parameters = [
            Parameter(
                f"{self.name}.{coefficient.name}{suffix}",
                coefficient.unit.format(effort=self.rig.effort_units[0], position=self.rig.position_units[0]),
                coefficient.meaning,
            )
            for suffix in suffixes
            for coefficient in self.effect.coefficients
        ]
        return *self.base.parameters, *effect_parameters

    @property
    def pointwise(self) -> bool:
        return False

    def regressor(self, motion: Motion) -> Floats:
        inputs = inputs_of(self.rig, self.base, motion, nominal_parameters(self.rig, self.base))
        return np.concatenate([self.base.regressor(motion), additive_columns(self.effect, inputs)], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        return self.base.nominal_torque(motion)


def with_rig(mechanism: Mechanism, rig: Rig) -> Mechanism:
    """Return the same `mechanism` for another `rig`."""
    if isinstance(mechanism, _MechanismWithEffect):
        return replace(mechanism, base=with_rig(mechanism.base, rig), rig=rig)
    return mechanisms.create(rig)


def additive_columns(effect: Additive, inputs: EffectInputs) -> Floats:
    """(n, dof, instances * c) torque per unit of each coefficient of the `effect` on every joint, joint by joint."""
    columns = effect.columns(inputs, middle_shapes(effect))
    if effect.whole_robot:
        return columns
    n, dof, c = columns.shape
    joint_columns = np.zeros((n, dof, dof, c))
    joint = np.arange(dof)
    joint_columns[:, joint, joint] = columns
    return joint_columns.reshape(n, dof, dof * c)


def middle_shapes(effect: Effect) -> Shapes:
    """Middle one of the initial guesses of each shape parameter of the `effect`."""
    return {
        shape.name: shape.initial_guesses[len(shape.initial_guesses) // 2]
        if shape.initial_guesses
        else _DEFAULT_SHAPE
        for shape in effect.shapes
    }


def nominal_parameters(rig: Rig, mechanism: Mechanism) -> Floats:
    """(k,) parameters of the `mechanism` with the masses of the rig file, half of each rod's mass at either end.

    Parameters that are not in the rig file are 0: friction, and all parameters of independent axes.
    """
    if rig.mechanism != "delta":
        return np.zeros(len(mechanism.parameters))
    nominal, arm = rig.nominal, rig.geometry.L1
    inertia = nominal.motor_inertia + nominal.I_L1 + nominal.m_a * nominal.L1c**2 + nominal.m_d / 2 * arm**2
    values = {f"I_{joint}": inertia for joint in (1, 2, 3)} | {
        "m_p": nominal.m_p + 3 * nominal.m_d / 2,
        "T_g": GRAVITY * (nominal.m_a * nominal.L1c + nominal.m_d / 2 * arm),
    }
    return np.array([values.get(parameter.name, 0.0) for parameter in mechanism.parameters])


def inputs_of(
    rig: Rig, mechanism: Mechanism, motion: Motion, parameters: Floats, rate: float = _RATE
) -> EffectInputs:
    """Inputs of effect functions in a `motion` that has not been recorded, at `rate` [Hz].

    parameters: (k,) of the `mechanism`; they determine the load.
    """
    rigid = np.array([0.0 if parameter.friction else 1.0 for parameter in mechanism.parameters]) * parameters

    def rigid_torque(motion: Motion) -> Floats:
        torque: Floats = mechanism.regressor(motion) @ rigid
        return torque

    values = {parameter.name: float(value) for parameter, value in zip(mechanism.parameters, parameters, strict=True)}
    values["m_d"] = sum(value for name, value in values.items() if name.endswith(".m_d"))
    return EffectInputs(rig, rate, np.arange(len(motion.position)) / rate, motion, rigid_torque, rate / 2, values)
