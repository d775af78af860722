"""Torque of a model structure in a motion that is given, and not recorded."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs, WatchedInputs
from ident.dynamics.effects.reading import PositionCorrection
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from recordings.errors import BadInput
from recordings.recording import Floats

_GIVEN = {
    "rate": "dt, the time from row to row [s]",
    "time": "t, the time since the run began [s]",
    "temperature": "temperature, that of the drives [degC]",
}
"""What of the inputs may not be given, and what to give for it."""


class NotGiven(BadInput):
    """An effect asks for what was not given. The text says what to give."""


@dataclass(frozen=True, eq=False)
class InverseDynamics:
    """A model structure with the values of its parameters, evaluated on motions of n instants."""

    structure: ModelStructure
    values: Floats
    """(K,)"""

    def inputs(
        self,
        motion: Motion,
        dt: float | None = None,
        t: Floats | None = None,
        temperature: Floats | None = None,
        end: float | None = None,
    ) -> EffectInputs:
        """Effect inputs of a `motion` as the encoders tell it.

        dt: from row to row [s]; t: (n,) time [s]; temperature: (n, dof) of the drives [degC]; end: time at which the
        run ends [s], None: with the last instant.
        """
        rig, corrections = self.structure.corrections(self.values, self.structure.rig)
        for correct in corrections:
            motion = _corrected(motion, correct)
        rate = np.nan if dt is None else 1 / dt
        time = np.full(len(motion.position), np.nan) if t is None else t
        load, arm_load_at, _ = self.structure.load(self.structure.load_parameters(self.values))
        known = MechanismMotion(rig, motion, self.structure.mechanism_of(rig)).effect_inputs(
            rate, time, rate / 2, load, temperature, end, arm_load_at
        )
        missing = {name for name, value in zip(_GIVEN, (dt, t, temperature), strict=True) if value is None}

        def refuse_missing(name: str) -> None:  # nothing is assumed about time and temperature
            if name in missing:
                raise NotGiven(_GIVEN[name])

        return WatchedInputs.of(known, refuse_missing)

    def columns(self, inputs: EffectInputs) -> Floats:
        """(n, dof, K_linear) torque per unit of each linear parameter, in the order of the vector.

        Raises:
            BadInput: an effect needs what the inputs do not have.
        """
        structure = self.structure
        columns = [structure.mechanism_columns(structure.mechanism_of(inputs.rig).regressor(inputs.motion))]
        for index, term, _ in structure.additive:
            with _naming(term):
                columns.append(term.by_instance(structure.columns(index, self.values, inputs)))
        return np.concatenate(columns, axis=2)

    def torque(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) [N m or N] at the motors: Eq. (26), every additive effect, elasticity and backlash.

        Raises:
            BadInput: as `columns`.
        """
        torque = self._additive_torque(inputs)
        for _, offset in self._offsets(inputs):
            torque = torque + offset
        return torque

    def terms(self, inputs: EffectInputs) -> dict[str, Floats]:
        """Parts (n, dof) of the `torque` by their cause: Eqs. (26)-(29), then each effect by its name.

        An effect that distorts only a measurement has no torque of its own: 0.

        Raises:
            BadInput: as `columns`.
        """
        parts = self._mechanism_terms(inputs)
        names = self.structure.term_names
        parts |= {name: np.zeros_like(inputs.motion.position) for name in names}
        for index, torque in (*self._additive_terms(inputs), *self._offsets(inputs)):
            parts[names[index]] = torque
        return parts

    def _mechanism_terms(self, inputs: EffectInputs) -> dict[str, Floats]:
        """Causes of the mechanism's torque: D(q) q'' on and off the diagonal, C(q, q') q', N(q, q') in parts."""
        motion, mechanism = inputs.motion, self.structure.mechanism_of(inputs.rig)
        values = self.structure.mechanism_values(self.values[self.structure.linear])
        regressor = mechanism.regressor(motion)
        names = [parameter.name for parameter in mechanism.parameters]
        friction = [np.array([name.startswith(prefix) for name in names]) for prefix in ("c_v", "c_c")]
        parts = (np.where(mask, values, 0.0) for mask in (~np.any(friction, axis=0), *friction))
        rigid, viscous, coulomb = (np.einsum("njk,k->nj", regressor, part) for part in parts)
        inertia, gravity = mechanism.inertia(motion, values), mechanism.gravity(motion, values)
        forces = inertia * motion.acceleration[:, None, :]
        diagonal = np.diagonal(forces, axis1=1, axis2=2).copy()
        coupling = forces.sum(axis=2) - diagonal
        return {
            "inertia": diagonal,
            "inertia_coupling": coupling,
            "coriolis": rigid - gravity - diagonal - coupling,
            "gravity": gravity,
            "viscous": viscous,
            "coulomb": coulomb,
        }

    def _additive_torque(self, inputs: EffectInputs) -> Floats:
        structure = self.structure
        regressor = structure.mechanism_of(inputs.rig).regressor(inputs.motion)
        # Not `@`, which multiplies instant by instant.
        torque: Floats = np.einsum("njk,k->nj", regressor, structure.mechanism_values(self.values[structure.linear]))
        for _, of_effect in self._additive_terms(inputs):
            torque += of_effect
        return torque

    def _additive_terms(self, inputs: EffectInputs) -> Iterator[tuple[int, Floats]]:
        """Yield the index of each additive term and its torque (n, dof)."""
        for index, term, _ in self.structure.additive:
            with _naming(term):
                columns = self.structure.columns(index, self.values, inputs)
            yield index, term.torque(columns, self.structure.local_values(index, self.values))

    def _offsets(self, inputs: EffectInputs) -> Iterator[tuple[int, Floats]]:
        """Yield the index of each effect between motor and arm, and the torque (n, dof) that it adds at the motor."""
        nothing = np.zeros_like(inputs.motion.position)
        for index, term, effect in self.structure.signals:
            if effect.report and effect.offset:
                with _naming(term):
                    yield index, effect.report(nothing, inputs, self.structure.signal_values(index, self.values))

    @property
    def distorts_report(self) -> bool:
        """Whether the drives report something else than the `torque`."""
        return any(effect.distorts_report for _, _, effect in self.structure.signals)

    def reported(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) that the rig's torque map makes of what the drives report, given the true torque.

        Raises:
            BadInput: as `columns`.
        """
        torque = self._additive_torque(inputs)
        for term, report in self.structure.reports(self.values):
            with _naming(term):
                torque = report(torque, inputs)
        return torque

    def terms_with_corrections(self, inputs_of: Callable[["InverseDynamics"], EffectInputs]) -> dict[str, Floats]:
        """As `terms`, with the torque that each correction of encoder or geometry changes as a term of its own.

        inputs_of: computes the inputs of effects for this model, or for one that lacks corrections. The causes of the
        mechanism are then those of the motion as it is reported, by the lengths of the rig file.
        """
        indices = [index for index, _, effect in self.structure.signals if effect.corrects_motion]
        names = self.structure.term_names
        model = self._without_distortion(indices)
        parts = model.terms(inputs_of(model))
        total = sum(parts.values(), start=np.zeros(1))
        for k, index in enumerate(indices, start=1):
            model = self._without_distortion(indices[k:])
            torque = model.torque(inputs_of(model))
            parts[names[index]], total = torque - total, torque
        return parts

    def _without_distortion(self, indices: Sequence[int]) -> "InverseDynamics":
        """Return the model in which the distortions with these `indices` are 0."""
        values = self.values.copy()
        for index in indices:
            shapes = len(self.structure.terms[index].shapes)
            entries = np.flatnonzero(self.structure.parameter_mask(index))
            values[entries[: len(entries) - shapes]] = 0.0
        return InverseDynamics(self.structure, values)


@contextmanager
def _naming(term: Term) -> Iterator[None]:
    """Say which effect asks for what was not given."""
    try:
        yield
    except NotGiven as missing:
        raise BadInput(f"effect {term.name} needs {missing}: none found; give it") from None


def _corrected(motion: Motion, correct: PositionCorrection) -> Motion:
    """The `motion` with its position corrected, and with what follows for its derivatives.

    With y = c(x): velocity c' x', acceleration c' x'' + c'' x'^2.
    """
    here = correct(motion.position)
    slope, bend = correct.slopes(here)
    velocity = slope * motion.velocity
    acceleration = slope * motion.acceleration + bend * motion.velocity**2
    return replace(motion, position=here, velocity=velocity, acceleration=acceleration)
