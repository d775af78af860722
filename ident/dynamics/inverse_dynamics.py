"""Torque of a model structure in a motion that is given, and not recorded."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, PositionCorrection, Term
from recordings.errors import BadInput
from recordings.recording import Floats

_STEP = 1e-4
"""Of the differences by which velocity and acceleration are corrected together with the position [rad or m]."""
_GIVEN = {
    "rate": "dt, the time from row to row [s]",
    "time": "t, the time since the run began [s]",
    "temperature": "temperature, that of the drives [degC]",
}
"""What of the inputs may not be given, and what to give for it."""


class NotGiven(BadInput):
    """An effect asks for what was not given. The text says what to give."""


@dataclass(frozen=True, eq=False)
class _Inputs(EffectInputs):
    """Effect inputs that refuse what was not given: nothing is assumed about time and temperature."""

    missing: frozenset[str] = frozenset()

    def __getattribute__(self, name: str) -> object:
        if name in _GIVEN and name in super().__getattribute__("missing"):
            raise NotGiven(_GIVEN[name])
        return super().__getattribute__(name)


@dataclass(frozen=True, eq=False)
class InverseDynamics:
    """A model structure with the values of its parameters, evaluated on motions of n instants."""

    structure: ModelStructure
    values: Floats
    """(K,)"""

    def inputs(
        self, motion: Motion, dt: float | None = None, t: Floats | None = None, temperature: Floats | None = None
    ) -> EffectInputs:
        """Effect inputs of a `motion` as the encoders tell it.

        dt: from row to row [s]; t: (n,) time [s]; temperature: (n, dof) of the drives [degC].
        """
        rig, corrections = self.structure.corrections(self.values)
        for correct in corrections:
            motion = _corrected(motion, correct)
        rate = np.nan if dt is None else 1 / dt
        time = np.full(len(motion.position), np.nan) if t is None else t
        known = MechanismMotion(rig, motion, self.structure.mechanism_of(rig)).effect_inputs(
            rate, time, rate / 2, self.structure.load_parameters(self.values), temperature
        )
        missing = {name for name, value in zip(_GIVEN, (dt, t, temperature), strict=True) if value is None}
        return _Inputs(**vars(known), missing=frozenset(missing))

    def columns(self, inputs: EffectInputs) -> Floats:
        """(n, dof, K_linear) torque per unit of each linear parameter, in the order of the vector.

        Raises:
            BadInput: an effect needs what the inputs do not have.
        """
        structure = self.structure
        columns = [structure.mechanism_columns(structure.mechanism_of(inputs.rig).regressor(inputs.motion))]
        for index, term in enumerate(structure.terms):
            if isinstance(term.effect, Additive):
                with _naming(term):
                    columns.append(term.by_instance(structure.columns(index, self.values, inputs)))
        return np.concatenate(columns, axis=2)

    def torque(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) [N m or N]: the mechanism's, Eq. (26), and that of every additive effect.

        Raises:
            BadInput: as `columns`.
        """
        torque: Floats = self.columns(inputs) @ self.values[self.structure.linear]
        return torque

    def reported(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) that the rig's torque map makes of what the drives report, given the true torque.

        Raises:
            BadInput: as `columns`.
        """
        torque = self.torque(inputs)
        for term, report in self.structure.reports(self.values):
            with _naming(term):
                torque = report(torque, inputs)
        return torque


@contextmanager
def _naming(term: Term) -> Iterator[None]:
    """Say which effect asks for what was not given."""
    try:
        yield
    except NotGiven as missing:
        raise BadInput(f"effect {term.name} needs {missing}: none found; give it") from None


def _corrected(motion: Motion, correct: PositionCorrection) -> Motion:
    """The `motion` with its position corrected, and with what follows for its derivatives.

    With y = c(x): velocity c' x', acceleration c' x'' + c'' x'^2, by central differences of c.
    """
    x = motion.position
    below, here, above = (correct(x + step) for step in (-_STEP, 0.0, _STEP))
    slope, bend = (above - below) / (2 * _STEP), (above - 2 * here + below) / _STEP**2
    velocity = slope * motion.velocity
    return Motion(here, velocity, slope * motion.acceleration + bend * motion.velocity**2, motion.direction)
