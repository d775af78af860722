"""The share of a residual that a candidate effect would remove, in every row of all recordings.

It follows the linearization used in `screening`: the candidate's columns times the coefficients estimated from the
training rows, while all parameters of the model adapt linearly.
"""

import numpy as np

from ident.diagnosis.search.screening import Candidate, effect_columns
from ident.diagnosis.split.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

_MIN_SINGULAR_VALUE = 1e-12
"""Singular values of the model's derivatives below this share of the largest count as zero."""


class EffectContribution:
    """A linearized model that can be combined with any number of candidates."""

    def __init__(self, split: SplitData, solution: Solution) -> None:
        self._split, self._solution = split, solution
        x, structure = solution.x, solution.structure
        linear = [predictor.linearized(structure, x) for predictor in split.predictors]
        self._computed = [computed for computed, _ in linear]
        self._derivatives = [derivatives for _, derivatives in linear]
        regressor, _ = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        size[size == 0] = 1.0
        self._inverse = np.linalg.pinv(regressor / size, rcond=_MIN_SINGULAR_VALUE) / size[:, None]

    def compute(self, candidate: Candidate) -> tuple[Floats, ...]:
        """(m, dof) torque that `candidate` removes from the residual of each recording [N m]; NaN where unknown."""
        term, scale, shapes = candidate.term, candidate.scale, candidate.shapes
        torques = [
            effect_columns(predictor, self._solution, term, scale, shapes, computed) @ candidate.coefficients
            for predictor, computed in zip(self._split.predictors, self._computed, strict=True)
        ]
        pairs = zip(self._split.train_indices, self._solution.weights, strict=True)
        rows = np.concatenate([(weight * torques[i])[weight > 0] for i, weight in pairs])
        adjustment = self._inverse @ np.nan_to_num(rows)
        return tuple(torque - slopes @ adjustment for torque, slopes in zip(torques, self._derivatives, strict=True))
