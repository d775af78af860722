"""The torque that an effect makes in a motion that nobody has recorded yet."""

from dataclasses import dataclass, replace

import numpy as np

from ident.design.with_effects import additive_columns, middle_shapes, with_rig, inputs_of
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Effect, Signal, Values
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.kinematics import Unreachable

_SMALLER = 0.25
"""Where the mechanism does not close with a distortion, one so much smaller is looked at."""
_LEAST = 1e-3
"""Over the size at first; then the motion itself is to blame."""


@dataclass(frozen=True, eq=False)
class EffectContext:
    """In what effects are looked at."""

    rig: Rig
    mechanism: Mechanism
    parameters: Floats
    """(k,) parameters of the mechanism, by which effects reckon the load."""
    rate: float = 500.0
    """Of the motions [Hz]."""

    def instances(self, effect: Effect) -> int:
        """How many sets of its parameters an effect has on all joints."""
        return 1 if effect.whole_robot else self.rig.dof

    def parameters_per_instance(self, effect: Effect) -> int:
        """Of so many parameters."""
        own = effect.coefficients if isinstance(effect, Additive) else effect.parameters  # type: ignore[attr-defined]
        return len(own)

    def parameter_count(self, effect: Effect) -> int:
        """All of them."""
        return self.instances(effect) * self.parameters_per_instance(effect)

    def columns(self, effect: Effect, motion: Motion) -> Floats:
        """Torque (n, dof, count) per unit of each parameter, joint by joint.

        Raises:
            Unreachable: the mechanism does not close in this motion.
        """
        if isinstance(effect, Additive):
            return additive_columns(effect, self.inputs(motion))
        assert isinstance(effect, Signal)
        view = self.inputs(motion)
        changes = [
            self._change(effect, view, owner, index, effect.parameters[index].initial_guesses[0])
            for owner in range(self.instances(effect))
            for index in range(self.parameters_per_instance(effect))
        ]
        return np.stack(changes, axis=2)

    def inputs(self, motion: Motion) -> EffectInputs:
        """What effects see of `motion`."""
        return inputs_of(self.rig, self.mechanism, motion, self.parameters, self.rate)

    def _change(self, effect: Signal, view: EffectInputs, owner: int, index: int, size: float) -> Floats:
        """Change (n, dof) of what is reported, per unit of one parameter, looked at with that `size` of it."""
        values = {one.name: np.zeros(self.instances(effect)) for one in effect.parameters}
        values[effect.parameters[index].name][owner] = size
        values |= {name: np.array([value]) for name, value in middle_shapes(effect).items()}
        try:
            change: Floats = np.nan_to_num((self._reported(effect, values, view) - view.rigid) / size)
        except Unreachable:
            if abs(size) < _LEAST * abs(effect.parameters[index].initial_guesses[0]):
                raise
            return self._change(effect, view, owner, index, _SMALLER * size)
        return change

    def _reported(self, effect: Signal, values: Values, view: EffectInputs) -> Floats:
        """Torque (n, dof) that is reported with these `values` of an effect, where `view` is what is measured."""
        true, motion = self, view.motion
        if effect.rig:
            rig = effect.rig(self.rig, values)
            true = replace(self, rig=rig, mechanism=with_rig(self.mechanism, rig))
        if effect.position:
            motion = replace(motion, position=effect.position(motion.position, self.rig, values))
        if effect.rig or effect.position:
            view = true.inputs(motion)
        return effect.report(view.rigid, view, values) if effect.report else view.rigid
