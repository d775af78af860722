"""Models of one set of recordings, each fitted once, and the changes that lead from one to another."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.shape_parameters import suggestions
from recordings.recording import Floats

Key = tuple[tuple[str, tuple[int, ...]], ...]
"""The effects of a model, each with its joints, in any order."""


def key_of(structure: ModelStructure) -> Key:
    """Identify a model by its effects."""
    return tuple(sorted((term.name, term.joints) for term in structure.terms))


class Fits:
    """Fits models, and keeps the best fit of each."""

    def __init__(self, split: SplitData) -> None:
        self.split = split
        self._best: dict[Key, FittedModel] = {}

    def best(self, model: FittedModel) -> FittedModel:
        """The best fit so far of the effects of `model`, which counts from now on."""
        key = key_of(model.solution.structure)
        known = self._best.get(key)
        if known is None or model.solution.loss < known.solution.loss:
            self._best[key] = model
        return self._best[key]

    def fit(self, structure: ModelStructure, x: Floats) -> FittedModel:
        """Fit `structure` starting from `x` (K,), or return the best fit that is known."""
        key = key_of(structure)
        if key not in self._best:
            self._best[key] = FittedModel(self.split, self.split.fit(structure, x))
        return self._best[key]

    def with_term(self, model: FittedModel, term: Term) -> FittedModel:
        """`model` with a `term` whose values start at 0."""
        structure = model.solution.structure.with_term(term)
        zeros = np.zeros(len(structure.parameters) - len(model.solution.x))
        return self.fit(structure, np.concatenate([model.solution.x, zeros]))

    def without_effect(self, model: FittedModel, index: int) -> FittedModel:
        """Refit `model` without its effect number `index`."""
        structure = model.solution.structure
        return self.fit(structure.without_term(index), model.solution.x[~structure.parameter_mask(index)])

    def on_joints(self, model: FittedModel, index: int, joints: Sequence[int]) -> FittedModel:
        """The effect number `index` of `model` on `joints` instead.

        A joint that it did not act on starts from the mean of the others, and from the opposite where it acts on
        none of the former ones: two lighter arms are one heavier arm.
        """
        structure, x, term = model.solution.structure, model.solution.x, model.terms[index]
        local, entries = structure.local_values(index, x), np.flatnonzero(structure.parameter_mask(index))
        kept = dict(zip(term.joints, local, strict=True))
        mean = local.mean(axis=0) if kept.keys() & set(joints) else -local.mean(axis=0)
        values = np.concatenate([kept.get(joint, mean) for joint in joints])
        moved = replace(term, joints=tuple(joints))
        shapes = structure.shape_values(index, x)
        if term.effect.local_shapes:
            predictors = [self.split.predictors[i] for i in self.split.train_indices]
            suggested = suggestions(term.effect, predictors, model.solution, model.solution.residuals)
            shapes = moved.shape_guesses(suggested)[0]
        terms = (*structure.terms[:index], moved, *structure.terms[index + 1 :])
        start = np.concatenate([x[: entries[0]], values, shapes, x[entries[-1] + 1 :]])
        return self.fit(replace(structure, terms=terms), start)


def added_term(before: FittedModel, after: FittedModel) -> int:
    """Number of the effect that `after` has in addition to, or on other joints than, the model `before`."""
    present = [(term.name, term.joints) for term in before.terms]
    for index, term in enumerate(after.terms):
        if (term.name, term.joints) not in present:
            return index
        present.remove((term.name, term.joints))
    return len(after.terms) - 1
