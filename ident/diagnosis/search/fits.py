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

    def on(self, split: SplitData) -> "Fits":
        """The same models, judged on the rows of `split`, which has the same training rows in its fits."""
        other = Fits(split)
        other._best = {key: FittedModel(split, model.solution) for key, model in self._best.items()}
        return other

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

    def without_effect(self, model: FittedModel, index: int) -> FittedModel:
        """Refit `model` without its effect number `index`."""
        structure = model.solution.structure
        return self.fit(structure.without_term(index), model.solution.x[~structure.parameter_mask(index)])

    def without_instances(self, model: FittedModel, index: int, kept: Sequence[bool]) -> FittedModel:
        """Keep the effect number `index` of `model` only on the joints that are `kept`, and refit."""
        structure, x = model.solution.structure, model.solution.x
        term, entries = model.terms[index], structure.instance_entries(index)
        joints = tuple(joint for joint, keep in zip(term.joints, kept, strict=True) if keep)
        terms = list(structure.terms)
        terms[index] = replace(term, joints=joints)
        return self.fit(replace(structure, terms=tuple(terms)), np.delete(x, entries[~np.array(kept)].ravel()))

    def on_other_joints(self, model: FittedModel, index: int) -> FittedModel | None:
        """The effect number `index` of `model` on all the other joints instead, if these are fewer; refitted."""
        structure, x, term = model.solution.structure, model.solution.x, model.terms[index]
        others = tuple(joint for joint in term.effect.possible_joints(structure.rig) if joint not in term.joints)
        if not 0 < len(others) < len(term.joints):
            return None
        local, terms = structure.local_values(index, x), list(structure.terms)
        terms[index] = replace(term, joints=others)
        entries = np.flatnonzero(structure.parameter_mask(index))[: local.size]
        opposite = np.tile(-local.mean(axis=0), len(others))
        start = np.insert(np.delete(x, entries), entries[0], opposite)
        return self.fit(replace(structure, terms=tuple(terms)), start)

    def on_more_joints(self, model: FittedModel, index: int, added: Sequence[int]) -> FittedModel:
        """The effect number `index` on the joints `added`, too, from the mean of the other joints' parameters."""
        narrow, x = model.solution.structure, model.solution.x
        term, local = model.terms[index], narrow.local_values(index, x)
        joints = tuple(sorted((*term.joints, *added)))
        by_joint = dict(zip(term.joints, local, strict=True))
        values = np.stack([by_joint.get(joint, local.mean(axis=0)) for joint in joints])
        wider = replace(term, joints=joints)
        shapes = narrow.shape_values(index, x)
        if term.effect.local_shapes:
            predictors = [self.split.predictors[i] for i in self.split.train_indices]
            suggested = suggestions(term.effect, predictors, model.solution, model.solution.residuals)
            shapes = wider.shape_guesses(suggested)[0]
        extended = narrow.without_term(index).with_term(wider)
        return self.fit(extended, np.concatenate([x[~narrow.parameter_mask(index)], values.ravel(), shapes]))

    def with_mandatory(self, model: FittedModel, terms: Sequence[Term]) -> list[FittedModel]:
        """The models with one after the other of the `terms` that `model` lacks, whose values start at 0."""
        models = []
        for term in terms:
            structure = model.solution.structure.with_term(term)
            zeros = np.zeros(len(structure.parameters) - len(model.solution.x))
            model = self.fit(structure, np.concatenate([model.solution.x, zeros]))
            models.append(model)
        return models


def added_term(before: FittedModel, after: FittedModel) -> int:
    """Number of the effect that `after` has in addition to, or on other joints than, the model `before`."""
    present = [(term.name, term.joints) for term in before.terms]
    for index, term in enumerate(after.terms):
        if (term.name, term.joints) not in present:
            return index
        present.remove((term.name, term.joints))
    return len(after.terms) - 1
