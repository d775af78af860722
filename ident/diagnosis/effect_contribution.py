"""The torque that a candidate would take away of what a model leaves: its signature, in every row of all recordings.

It is what `screen` reckons its gain from: columns at the place where they were looked at, times coefficients found
from all rows that fits may see, while all parameters of the model follow on a straight line.
"""

import numpy as np

from ident.diagnosis.screening import Candidate
from ident.diagnosis.split_data import SplitData
from ident.dynamics.effects.base import Additive
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import Evaluator
from recordings.recording import Floats

_NOTHING = 1e-12
"""Singular values of the model's derivatives below this share of the largest."""


class EffectContribution:
    """A model, ready for any number of candidates."""

    def __init__(self, material: SplitData, solution: Solution) -> None:
        self._material, self._solution = material, solution
        x, composition = solution.x, solution.composition
        self._rigid = composition.load(x)
        linear = [one.linearised(composition, x) for one in material.predictors]
        self._computed = [computed for computed, _ in linear]
        self._derivatives = [derivatives for _, derivatives in linear]
        regressor, _ = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        size[size == 0] = 1.0
        self._inverse = np.linalg.pinv(regressor / size, rcond=_NOTHING) / size[:, None]

    def compute(self, candidate: Candidate) -> tuple[Floats, ...]:
        """(m, dof) what `candidate` would take away of the residual of each recording [N m]; NaN where not known."""
        added = [
            self._added(evaluator, computed, candidate)
            for evaluator, computed in zip(self._material.predictors, self._computed, strict=True)
        ]
        pairs = zip(self._material.train_indices, self._solution.weights, strict=True)
        rows = np.concatenate([(weight * added[i])[weight > 0] for i, weight in pairs])
        follows = self._inverse @ np.nan_to_num(rows)
        return tuple(one - slopes @ follows for one, slopes in zip(added, self._derivatives, strict=True))

    def _added(self, evaluator: Evaluator, computed: Floats, candidate: Candidate) -> Floats:
        """(m, dof) what the candidate's columns give, while the model stays as it is."""
        term, x, composition = candidate.term, self._solution.x, self._solution.composition
        if isinstance(term.effect, Additive):
            path = evaluator.path(composition, x)
            columns = evaluator.columns(term, candidate.shapes, path, self._rigid)
            return evaluator.course.condition(columns @ candidate.coefficients)
        total = np.zeros_like(computed)
        parts = candidate.scale.shape[1]
        for number, coefficient in enumerate(candidate.coefficients):
            joints = term.joints if term.effect.whole_robot else term.joints[number // parts : number // parts + 1]
            own = np.where(np.arange(parts) == number % parts, candidate.scale[number // parts], 0.0)
            one = composition.plus(Term(term.name, term.effect, joints))
            moved = evaluator.torque(one, np.concatenate([x, own, candidate.shapes]), self._rigid)
            total += coefficient * (moved - computed)
        return total
