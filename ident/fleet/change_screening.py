"""Screen what may have changed between recordings before and after: one effect that only the later ones have.

All parameters are common to all recordings, so that nothing of the change is absorbed by a second fit. Each parameter
may differ from night to night by its usual scatter (a normal prior), so that a warmer night is no effect.
"""

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from ident.basics.statistics import TINY
from ident.diagnosis.search.screening import Candidate, Screener, column_basis
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Additive, Effect, Quantity
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Bools, Floats

PARAMETER_NAMES = {
    "c_v": "viscous_friction",
    "c_c": "coulomb_friction",
    "I_": "joint_inertia",
    "m_p": "platform_mass",
    "T_g": "arm_gravity",
    "rod_inertia.m_d": "rod_mass",
}
"""What a change of a parameter is called in an alarm; others have the name of the parameter."""
_PER_JOINT = re.compile(r"^(.*?)(\d+)$")


class ChangeScreener(Screener):
    """Screens effects that only some recordings have."""

    def __init__(self, split: SplitData, solution: Solution, changed: Sequence[bool], scatter: Floats) -> None:
        """`changed`: whether a recording is one of the later ones; scatter: (recordings, K) standard deviation of
        each parameter from night to night."""
        super().__init__(split, solution)
        used = split.train_indices
        counts = [int((solution.weights[k] > 0).sum()) for k in range(len(used))]
        recording = np.repeat(np.arange(len(used)), counts)
        self._changed: Bools = np.repeat(np.array([changed[i] for i in used]), counts)
        columns = [
            np.where(recording == k, self.regressor[:, entry] * scatter[i, entry], 0.0)
            for k, i in enumerate(used)
            for entry in np.flatnonzero(scatter[i] > 0)
        ]
        self._own_regressor = self.regressor
        nights = np.column_stack(columns) if columns else np.zeros((len(recording), 0))
        penalties = np.zeros((len(columns), self.regressor.shape[1])), np.eye(len(columns))
        self.regressor = np.block([[self.regressor, nights], [*penalties]])
        self._basis = column_basis(self.regressor)
        self.residual = np.concatenate([self.residual, np.zeros(len(columns))])
        rest = self.residual - self._basis @ (self._basis.T @ self.residual)
        self.loss = float(rest @ rest)

    def parameter_effects(self) -> dict[str, Effect]:
        """Effects that stand for other values of parameters that the model has already."""
        return {name: _parameter_effect(whole_robot=len(entries) == 1) for name, entries in self._parameters.items()}

    @property
    def row_count(self) -> int:
        """Number of rows of all recordings."""
        return len(self._changed)

    def loss_before(self) -> tuple[float, int]:
        """Weighted sum of squares of the earlier recordings with parameters of their own, and the number of rows."""
        rows = np.concatenate([~self._changed, np.ones(len(self.residual) - len(self._changed), bool)])
        basis, residual = column_basis(self.regressor[rows]), self.residual[rows]
        rest = residual - basis @ (basis.T @ residual)
        return float(rest @ rest), int((~self._changed).sum())

    def fading_reduction(self, candidate: Candidate) -> float:
        """Further reduction of the loss if the `candidate` may grow or fade during each of the later recordings."""
        columns = self.columns(candidate.term, candidate.scale, candidate.shapes)
        both = self.orthogonal(np.hstack([columns, columns * self._time[:, None]]))
        rest = self.residual - self._basis @ (self._basis.T @ self.residual)
        steady, fading = (
            rest - used @ np.linalg.lstsq(used, rest, rcond=1e-10)[0] for used in (both[:, : columns.shape[1]], both)
        )
        return float(steady @ steady - fading @ fading)

    def torque_after(self) -> float:
        """Weighted sum of squares of the torque of the later recordings."""
        torque = [
            (weight * predictor.prepared.torque)[weight > 0]
            for weight, predictor in zip(self._solution.weights, self._predictors, strict=True)
        ]
        return float((np.concatenate(torque)[self._changed] ** 2).sum())

    @cached_property
    def _time(self) -> Floats:
        """(r,) time of each row in its recording, from -1 to 1; 0 in the prior's rows."""
        times = []
        for weight, predictor in zip(self._solution.weights, self._predictors, strict=True):
            time = predictor.prepared.time
            relative = 2 * (time - time[0]) / max(time[-1] - time[0], TINY) - 1
            times.append(np.broadcast_to(relative[:, None], weight.shape)[weight > 0])
        return np.concatenate([*times, np.zeros(len(self.residual) - len(self._changed))])

    @cached_property
    def _parameters(self) -> dict[str, list[int]]:
        """Entries of the parameters of each name, one per joint or one of the whole robot."""
        groups: dict[str, list[int]] = defaultdict(list)
        for index, entry in enumerate(self._solution.structure.parameters):
            groups[base_name(entry.name)].append(index)
        dof = self._solution.structure.rig.dof
        return {
            PARAMETER_NAMES.get(name, name): entries for name, entries in groups.items() if len(entries) in (1, dof)
        }

    def columns(self, term: Term, guess: Floats, shapes: Floats) -> Floats:
        """See `Screener`."""
        if term.name in self._parameters:
            return self._only_changed(self._own_regressor[:, self._parameters[term.name]])
        return self._only_changed(super().columns(term, guess, shapes))

    def _only_changed(self, columns: Floats) -> Floats:
        """The `columns` (r, c) in the later recordings, 0 in the earlier ones and in the prior's rows."""
        prior_rows = len(self.residual) - len(self._changed)
        return np.vstack([np.where(self._changed[:, None], columns, 0.0), np.zeros((prior_rows, columns.shape[1]))])


def as_change(effect: Effect) -> Effect:
    """The `effect` as a difference between nights: what takes the place of friction is then added to it, and may be
    negative."""
    if effect.replaces is None:
        return effect
    free = tuple(replace(quantity, lower=-np.inf) for quantity in effect.parameters)
    return effect.changed(replaces=None, parameters=free)


def base_name(name: str) -> str:
    """Name of a parameter without the number of its joint."""
    return match.group(1) if (match := _PER_JOINT.match(name)) else name


def _parameter_effect(whole_robot: bool) -> Additive:
    """Stands for a parameter of the mechanism: only its joints matter."""
    return Additive(
        sentence="",
        symptom="",
        causes="",
        remedy="",
        equation="",
        axis="velocity",
        whole_robot=whole_robot,
        parameters=(Quantity(name="change", unit="", meaning="change of the parameter"),),
        columns=lambda inputs, shapes: inputs.motion.velocity[:, :, None],
    )
