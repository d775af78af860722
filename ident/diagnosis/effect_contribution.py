"""The share of a residual that a candidate effect would remove, in every row of all recordings.

It follows the linearization used in `screening`: the candidate's columns times the coefficients estimated from the
training rows, while all parameters of the model adapt linearly.
"""

import numpy as np

from ident.diagnosis.screening import Candidate
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

    def __init__(self, material: SplitData, solution: Solution) -> None:
        self._split, self._solution = material, solution
        x, composition = solution.x, solution.structure
        self._rigid = composition.load(x)
        linear = [one.linearized(composition, x) for one in material.predictors]
        self._computed = [computed for computed, _ in linear]
        self._derivatives = [derivatives for _, derivatives in linear]
        regressor, _ = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        size[size == 0] = 1.0
        self._inverse = np.linalg.pinv(regressor / size, rcond=_MIN_SINGULAR_VALUE) / size[:, None]

    def compute(self, candidate: Candidate) -> tuple[Floats, ...]:
        """(m, dof) torque that `candidate` would remove from the residual of each recording [N m]; NaN where
        unknown.
        """
        added = [
            self._candidate_torque(evaluator, computed, candidate)
            for evaluator, computed in zip(self._split.predictors, self._computed, strict=True)
        ]
        pairs = zip(self._split.train_indices, self._solution.weights, strict=True)
        rows = np.concatenate([(weight * added[i])[weight > 0] for i, weight in pairs])
        follows = self._inverse @ np.nan_to_num(rows)
        return tuple(one - slopes @ follows for one, slopes in zip(added, self._derivatives, strict=True))

    def _candidate_torque(self, evaluator: TorquePredictor, computed: Floats, candidate: Candidate) -> Floats:
        """(m, dof) torque of the candidate's columns, with the model's parameters unchanged."""
        term, x, composition = candidate.term, self._solution.x, self._solution.structure
        if isinstance(term.effect, Additive):
            path = evaluator.corrected_motion(composition, x)
            columns = evaluator.columns(term, candidate.shapes, path, self._rigid)
            return evaluator.prepared.condition(columns @ candidate.coefficients)
        total = np.zeros_like(computed)
        parts = candidate.scale.shape[1]
        for number, coefficient in enumerate(candidate.coefficients):
            joints = term.joints if term.effect.whole_robot else term.joints[number // parts : number // parts + 1]
            own = np.where(np.arange(parts) == number % parts, candidate.scale[number // parts], 0.0)
            one = composition.plus(Term(term.name, term.effect, joints))
            moved = evaluator.torque(one, np.concatenate([x, own, candidate.shapes]), self._rigid)
            total += coefficient * (moved - computed)
        return total
