"""Torque of an effect in a motion that has not been recorded."""

from dataclasses import dataclass, replace

import numpy as np

from ident.design.with_effects import additive_columns, inputs_of, middle_shapes, with_rig
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Effect, Signal, Values
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.kinematics import Unreachable

_REDUCTION = 0.25
"""Factor of a distortion with which the mechanism does not close, for the next attempt."""
_MIN_SIZE = 1e-3
"""Minimum distortion relative to the first one; below it, the motion itself is unreachable."""


@dataclass(frozen=True, eq=False)
class EffectContext:
    """Rig and mechanism for which the torque of effects is computed."""

    rig: Rig
    mechanism: Mechanism
    parameters: Floats
    """(k,) parameters of the mechanism, for effects that depend on the load."""
    rate: float = 500.0
    """Sample rate of the motions [Hz]."""

    def instances(self, effect: Effect) -> int:
        """Number of instances of `effect`: one for each joint, or one for the whole robot."""
        return 1 if effect.whole_robot else self.rig.dof

    def parameters_per_instance(self, effect: Effect) -> int:
        """Number of linear coefficients or signal parameters of one instance of `effect`."""
        quantities = effect.coefficients if isinstance(effect, Additive) else effect.parameters  # type: ignore[attr-defined]
        return len(quantities)

    def parameter_count(self, effect: Effect) -> int:
        """Number of parameters of all instances of `effect`."""
        return self.instances(effect) * self.parameters_per_instance(effect)

    def columns(self, effect: Effect, motion: Motion) -> Floats:
        """(n, dof, parameter_count) torque per unit of each parameter, joint by joint.

        Raises:
            Unreachable: the mechanism does not close in this motion.
        """
        if isinstance(effect, Additive):
            return additive_columns(effect, self.inputs(motion))
        assert isinstance(effect, Signal)
        inputs = self.inputs(motion)
        changes = [
            self._change(effect, inputs, instance, index, effect.parameters[index].initial_guesses[0])
            for instance in range(self.instances(effect))
            for index in range(self.parameters_per_instance(effect))
        ]
        return np.stack(changes, axis=2)

    def inputs(self, motion: Motion) -> EffectInputs:
        """Inputs of effect functions in `motion`."""
        return inputs_of(self.rig, self.mechanism, motion, self.parameters, self.rate)

    def _change(self, effect: Signal, inputs: EffectInputs, instance: int, index: int, size: float) -> Floats:
        """(n, dof) change of the reported torque per unit of one parameter, by a finite difference of that `size`."""
        values = {parameter.name: np.zeros(self.instances(effect)) for parameter in effect.parameters}
        values[effect.parameters[index].name][instance] = size
        values |= {name: np.array([value]) for name, value in middle_shapes(effect).items()}
        try:
            change: Floats = np.nan_to_num((self._reported_torque(effect, values, inputs) - inputs.rigid) / size)
        except Unreachable:
            if abs(size) < _MIN_SIZE * abs(effect.parameters[index].initial_guesses[0]):
                raise
            return self._change(effect, inputs, instance, index, _REDUCTION * size)
        return change

    def _reported_torque(self, effect: Signal, values: Values, inputs: EffectInputs) -> Floats:
        """(n, dof) torque that is reported with the parameter `values` of `effect`; `inputs` are as measured."""
        true, motion = self, inputs.motion
        if effect.rig:
            rig = effect.rig(self.rig, values)
            true = replace(self, rig=rig, mechanism=with_rig(self.mechanism, rig))
        if effect.position:
            motion = replace(motion, position=effect.position(motion.position, self.rig, values))
        if effect.rig or effect.position:
            inputs = true.inputs(motion)
        return effect.report(inputs.rigid, inputs, values) if effect.report else inputs.rigid
