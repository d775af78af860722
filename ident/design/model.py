"""A mechanism with effects in motions that have not been recorded: the torque of each of its parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.library import load, names
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.checks import nominal_parameters
from trajectories.kinematics import Unreachable

_REDUCTION = 0.25
"""Factor of a distortion with which the mechanism does not close, for the next attempt."""
_MIN_SIZE = 1e-3
"""Minimum distortion relative to the first one; below it, the motion itself is unreachable."""


@dataclass(frozen=True, eq=False)
class DesignModel:
    """A model structure whose shapes are at the middle of their initial guesses, linear in its other parameters."""

    structure: ModelStructure
    values: Floats
    """(K,) parameters; those of the mechanism determine the load."""
    rate: float = 500.0
    """Sample rate of the motions [Hz]; only effects with memory depend on it."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The k linear parameters."""
        return self.structure.linear_parameters

    def regressor(self, motion: Motion) -> Floats:
        """(n, dof, k) columns of the linear parameters."""
        dynamics = InverseDynamics(self.structure, self.values)
        return dynamics.columns(self._inputs(dynamics, motion))

    def with_parameters(self, parameters: Floats) -> "DesignModel":
        """Return the model with other linear `parameters` (k,)."""
        values = self.values.copy()
        values[self.structure.linear] = parameters
        return replace(self, values=values)

    def columns(self, term: Term, motion: Motion) -> Floats:
        """(n, dof, instances * c) torque per unit of each local parameter of a further `term`, instance by instance.

        Raises:
            Unreachable: the mechanism does not close in this motion.
        """
        size = term.instances * len(term.local_parameters)
        values = np.concatenate([self.values, np.zeros(size), term.effect.typical_shapes])
        extended = InverseDynamics(self.structure.with_term(term), values)
        if term.effect.linear:
            return extended.columns(self._inputs(extended, motion))[:, :, -size:]
        without = extended.reported(self._inputs(extended, motion))
        guesses = [quantity.first_guess for quantity in term.local_parameters] * term.instances
        changes = [
            self._change(extended, motion, without, len(self.values) + entry, guess)
            for entry, guess in enumerate(guesses)
        ]
        return np.stack(changes, axis=2)

    def _change(
        self, dynamics: InverseDynamics, motion: Motion, without: Floats, entry: int, guess: float, share: float = 1.0
    ) -> Floats:
        """(n, dof) change of the reported torque per unit of one parameter, by a `share` of its initial `guess`."""
        values = dynamics.values.copy()
        values[entry] = share * guess
        distorted = InverseDynamics(dynamics.structure, values)
        try:
            reported = distorted.reported(self._inputs(distorted, motion))
        except Unreachable:
            if share < _MIN_SIZE:
                raise
            return self._change(dynamics, motion, without, entry, guess, _REDUCTION * share)
        return np.nan_to_num((reported - without) / values[entry])

    def _inputs(self, dynamics: InverseDynamics, motion: Motion) -> EffectInputs:
        return dynamics.inputs(motion, 1 / self.rate, np.arange(len(motion.position)) / self.rate)


def with_effects(rig: Rig, effects: Sequence[str]) -> DesignModel:
    """Return the mechanism of `rig` with `effects` on every joint, and the masses of the rig file.

    Raises:
        BadInput: an effect is named twice, does not exist for this mechanism, or does not add a torque.
    """
    terms = []
    for name in effects:
        if effects.count(name) > 1:
            raise BadInput(f"every effect once expected, '{name}' found twice; remove one")
        effect = load(name)
        if not effect.linear or rig.mechanism not in effect.mechanisms or effect.axis == "time":
            raise BadInput(
                f"effect {name}: an effect expected that adds torque to a {rig.mechanism} and does not change with "
                "time; remove it"
            )
        terms.append(Term.on_all_joints(name, effect, rig))
    structure = ModelStructure(mechanisms.create(rig), rig, tuple(terms))
    known = _nominal_parameters(rig)
    values = np.array([known.get(entry.name, 0.0) for entry in structure.parameters])
    for index, term in enumerate(terms):
        values[structure.parameter_mask(index) & ~structure.linear] = term.effect.typical_shapes
    return DesignModel(structure, values)


def mandatory_effects(rig: Rig) -> list[str]:
    """Names of the effects that every model of this mechanism includes."""
    return [name for name in names() if (effect := load(name)).mandatory and rig.mechanism in effect.mechanisms]


def _nominal_parameters(rig: Rig) -> dict[str, float]:
    """Parameters that follow from the masses of the rig file.

    Others are 0: friction, effects, and all parameters of independent axes.
    """
    if rig.mechanism != "delta":
        return {}
    m_p, T_g, inertia = nominal_parameters(rig)
    return {"m_p": m_p, "T_g": T_g, **{f"I_{joint}": inertia for joint in (1, 2, 3)}}
