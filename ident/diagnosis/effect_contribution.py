"""The share of a residual that a candidate effect would remove, in every row of all recordings.

It follows the linearization used in `screening`: the candidate's columns times the coefficients estimated from the
training rows, while all parameters of the model adapt linearly.
"""

import numpy as np

from ident.diagnosis.screening import Candidate, added_columns
from ident.diagnosis.split_data import SplitData
from ident.dynamics.effects.base import Additive
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats

_MIN_SINGULAR_VALUE = 1e-12
"""Singular values of the model's derivatives below this share of the largest count as zero."""


class EffectContribution:
    """A linearized model that can be combined with any number of candidates."""

    def __init__(self, split: SplitData, solution: Solution) -> None:
        self._split, self._solution = split, solution
        x, structure = solution.x, solution.structure
        self._rigid = structure.load_parameters(x)
        linear = [predictor.linearized(structure, x) for predictor in split.predictors]
        self._computed = [computed for computed, _ in linear]
        self._derivatives = [derivatives for _, derivatives in linear]
        regressor, _ = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        size[size == 0] = 1.0
        self._inverse = np.linalg.pinv(regressor / size, rcond=_MIN_SINGULAR_VALUE) / size[:, None]

    def compute(self, candidate: Candidate) -> tuple[Floats, ...]:
        """(m, dof) torque that `candidate` removes from the residual of each recording [N m]; NaN where unknown."""
        torques = [
            self._candidate_torque(predictor, computed, candidate)
            for predictor, computed in zip(self._split.predictors, self._computed, strict=True)
        ]
        pairs = zip(self._split.train_indices, self._solution.weights, strict=True)
        rows = np.concatenate([(weight * torques[i])[weight > 0] for i, weight in pairs])
        adjustment = self._inverse @ np.nan_to_num(rows)
        return tuple(torque - slopes @ adjustment for torque, slopes in zip(torques, self._derivatives, strict=True))

    def _candidate_torque(self, predictor: TorquePredictor, computed: Floats, candidate: Candidate) -> Floats:
        """(m, dof) torque of the candidate's columns, with the model's parameters unchanged."""
        term, x, structure = candidate.term, self._solution.x, self._solution.structure
        if isinstance(term.effect, Additive):
            columns = added_columns(predictor, self._solution, term, candidate.shapes)
            return predictor.prepared.condition(columns @ candidate.coefficients)
        total = np.zeros_like(computed)
        count = candidate.scale.shape[1]
        for index, coefficient in enumerate(candidate.coefficients):
            joints = term.joints if term.effect.whole_robot else term.joints[index // count : index // count + 1]
            local = np.where(np.arange(count) == index % count, candidate.scale[index // count], 0.0)
            extended = structure.with_term(Term(term.name, term.effect, joints))
            torque = predictor.torque(extended, np.concatenate([x, local, candidate.shapes]), self._rigid)
            total += coefficient * (torque - computed)
        return total
