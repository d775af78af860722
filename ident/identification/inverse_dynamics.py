"""Torque of an identified model for a motion that is given, and not recorded."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ident.data.prepared_recording import CorrectedMotion
from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.predicted_torque import position_correction
from recordings.errors import BadInput
from recordings.recording import Floats

_STEP = 1e-4
"""Of the differences by which velocity and acceleration are corrected together with the position [rad or m]."""
_TIME = {"rate": "dt, the time from row to row [s]", "time": "t, the time since the run began [s]"}
"""What of the inputs may not be given, and what to give for it."""


class NotGiven(BadInput):
    """An effect asks for what was not given. The text says what to give."""


@dataclass(frozen=True, eq=False)
class _Inputs(EffectInputs):
    """Effect inputs that refuse what was not given: nothing is assumed about time."""

    missing: frozenset[str] = frozenset()

    def __getattribute__(self, name: str) -> object:
        if name in _TIME and name in super().__getattribute__("missing"):
            raise NotGiven(_TIME[name])
        return super().__getattribute__(name)


@dataclass(frozen=True, eq=False)
class InverseDynamics:
    """A model structure with the values of its parameters, evaluated on motions of n instants."""

    structure: ModelStructure
    values: Floats
    """(K,)"""

    def inputs(self, motion: Motion, dt: float | None = None, t: Floats | None = None) -> EffectInputs:
        """Effect inputs of a `motion` as the encoders tell it. dt: from row to row [s]; t: (n,) time [s]."""
        rig = self.structure.rig
        for index, term in enumerate(self.structure.terms):
            if isinstance(term.effect, Signal) and (term.effect.rig or term.effect.position):
                values = self.structure.signal_values(index, self.values)
                rig = term.effect.rig(rig, values) if term.effect.rig else rig
                if term.effect.position:
                    motion = _corrected(motion, position_correction(term.effect.position, rig, values))
        mechanism = self.structure.mechanism if rig is self.structure.rig else mechanisms.create(rig)
        rate = np.nan if dt is None else 1 / dt
        time = np.full(len(motion.position), np.nan) if t is None else t
        known = CorrectedMotion(rig, motion, mechanism).effect_inputs(
            rate, time, rate / 2, self.structure.load_parameters(self.values)
        )
        missing = {name for name, value in (("rate", dt), ("time", t)) if value is None}
        return _Inputs(**vars(known), missing=frozenset(missing))

    def torque(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) [N m or N]: the mechanism's, Eq. (26), and that of every additive effect.

        Raises:
            BadInput: an effect needs what the inputs do not have.
        """
        structure, linear = self.structure, self.values[self.structure.linear]
        mechanism = mechanisms.create(inputs.rig) if inputs.rig is not structure.rig else structure.mechanism
        regressor = mechanism.regressor(inputs.motion)
        torque: Floats = regressor @ linear[: regressor.shape[2]]
        for index, term in enumerate(structure.terms):
            if isinstance(term.effect, Additive):
                torque += self._added(index, term, term.effect, inputs)
        return torque

    def _added(self, index: int, term: Term, effect: Additive, inputs: EffectInputs) -> Floats:
        shapes = self.structure.shape_values(index, self.values).tolist()
        by_name = dict(zip((shape.name for shape in effect.shapes), shapes, strict=True))
        with _naming(term):
            columns = effect.columns(inputs, by_name)
        local = self.structure.local_values(index, self.values)
        if effect.whole_robot:
            torque: Floats = columns @ local[0]
            return torque
        joints = list(term.joints)
        torque = np.where(np.isfinite(inputs.motion.velocity), 0.0, np.nan)
        torque[:, joints] += np.einsum("njc,jc->nj", columns[:, joints], local)
        return torque

    def reported(self, inputs: EffectInputs) -> Floats:
        """Torque (n, dof) that the rig's torque map makes of what the drives report, given the true torque.

        Raises:
            BadInput: as `torque`.
        """
        torque = self.torque(inputs)
        for index, term in enumerate(self.structure.terms):
            if isinstance(term.effect, Signal) and term.effect.report:
                with _naming(term):
                    torque = term.effect.report(torque, inputs, self.structure.signal_values(index, self.values))
        return torque


@contextmanager
def _naming(term: Term) -> Iterator[None]:
    """Say which effect asks for what was not given."""
    try:
        yield
    except NotGiven as missing:
        raise BadInput(f"effect {term.name} needs {missing}: none found; give it") from None


def _corrected(motion: Motion, correct: Callable[[Floats], Floats]) -> Motion:
    """The `motion` with its position corrected, and with what follows for its derivatives.

    With y = c(x): velocity c' x', acceleration c' x'' + c'' x'^2, by central differences of c.
    """
    x = motion.position
    below, here, above = (correct(x + step) for step in (-_STEP, 0.0, _STEP))
    slope, bend = (above - below) / (2 * _STEP), (above - 2 * here + below) / _STEP**2
    velocity = slope * motion.velocity
    return Motion(here, velocity, slope * motion.acceleration + bend * motion.velocity**2, motion.direction)
