"""Candidate effects for a model: screen every effect of the library and refine the most promising ones."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.physical_limits import within_limits
from ident.diagnosis.judge.steps import Exclusion, Extensions, FittedModel
from ident.diagnosis.search.pair_screening import screen_pairs
from ident.diagnosis.search.screening import Candidate, Screener
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.shape_parameters import suggestions
from ident.threads import in_threads
from recordings.recording import Floats

MAX_REFINED = 8
"""Number of candidates whose nonlinear parameters are optimized in each round."""
MIN_PROMISE = 0.4
"""A candidate is not refined if screening promises less than this share of the best reduction so far: optimizing its
parameters seldom doubles that."""
MIN_SIGNIFICANCE = 15.0
"""A reduction of the loss is significant if it exceeds this many times what the same number of parameters gains by
fitting noise."""
_MIN_REALISED = 0.95
"""Share of the reduction promised by screening that an optimization must reach; otherwise the next start is tried."""

_EffectKey = tuple[tuple[str, tuple[int, ...]], ...]
"""The effects of a model, each with its joints."""
Screening = tuple[list[Candidate], Mapping[str, Exclusion], Mapping[str, float]]
"""Candidates, excluded effects, and the relative reductions of the loss: see `CandidateSearch.screen`."""


class CandidateSearch:
    """Search a library of effects for extensions of a model."""

    def __init__(self, split: SplitData, library: Mapping[str, Effect]) -> None:
        self._split, self._library = split, library
        self._extensions: dict[_EffectKey, Extensions] = {}
        self._screened: dict[_EffectKey, Screening] = {}

    def extensions(self, model: FittedModel) -> Extensions:
        """All extensions of `model` by one effect."""
        key = effect_key(model)
        if key not in self._extensions:
            self._extensions[key] = self._refined(model, self._screening(model))
        return self._extensions[key]

    def promised_loss(self, model: FittedModel) -> float:
        """Smallest loss that screening promises for an extension of `model`; infinite where nothing extends it."""
        return min((candidate.loss for candidate in self._screening(model)[0]), default=np.inf)

    def alternatives(self, name: str, reduced: FittedModel) -> list[FittedModel]:
        """Extensions of `reduced`, a model without the effect `name`, by another effect."""
        extensions = self._extensions.get(effect_key(reduced))
        return [
            extension
            for extension in (extensions or self._refined(reduced, self.screen(reduced, name))).models
            if extension.terms[-1].name != name
        ]

    def fit(self, structure: ModelStructure, x: Floats) -> FittedModel:
        """Fit the model `structure` starting from `x` (K,)."""
        return FittedModel(self._split, self._split.fit(structure, x))

    def without_effect(self, model: FittedModel, index: int) -> FittedModel:
        """Refit `model` without its effect number `index`."""
        structure = model.solution.structure
        return self.fit(structure.without_term(index), model.solution.x[~structure.parameter_mask(index)])

    def chance_reduction(self, loss: float) -> float:
        """Reduction of the loss that one more parameter gains by fitting noise."""
        return loss / self._split.independent_rows

    def is_significant(self, before: float, after: float, parameters: int) -> bool:
        """Whether the loss falls by more than so many `parameters` gain by fitting noise."""
        return before - after > MIN_SIGNIFICANCE * parameters * self.chance_reduction(after)

    def is_redundant(self, name: str, model: FittedModel, other: FittedModel) -> bool:
        """Whether the last effect of `other` contains the effect `name` of `model` and explains no more than that."""
        parameters = max(len(other.solution.x) - len(model.solution.x), 0)
        contained = name in other.terms[-1].effect.contains
        return contained and not self.is_significant(model.solution.loss, other.solution.loss, parameters)

    def skipped_extensions(self, model: FittedModel) -> list[FittedModel]:
        """Extensions of `model` that `extensions` did not refine because others promised more; the best first."""
        refined = {extension.terms[-1] for extension in self.extensions(model).models}
        significant = self._significant(model, self._screening(model)[0])
        skipped = [
            candidate for candidate in significant if all(candidate.term.name != term.name for term in refined)
        ][:MAX_REFINED]
        return sorted(
            (self.add(model, candidate) for candidate in skipped), key=lambda extension: extension.solution.loss
        )

    def replace_last(self, model: FittedModel, name: str) -> FittedModel | None:
        """Replace the last effect of `model` by the effect `name` on the same joints; None: the library lacks it.

        If `model` has that effect, too, one effect on the joints of both replaces them.
        """
        if name not in self._library:
            return None
        joints, structure, x = set(model.terms[-1].joints), model.solution.structure, model.solution.x
        for index in range(len(model.terms) - 1, -1, -1):
            if index == len(model.terms) - 1 or model.terms[index].name == name:
                joints |= set(model.terms[index].joints)
                x = x[~structure.parameter_mask(index)]
                structure = structure.without_term(index)
        reduced = structure.with_term(Term(name, self._library[name], tuple(sorted(joints))))
        return self.fit(reduced, np.concatenate([x, np.zeros(len(reduced.parameters) - len(x))]))

    def moved_to_end(self, model: FittedModel, index: int) -> FittedModel:
        """The same `model`, with its effect number `index` as the last one."""
        structure, mask = model.solution.structure, model.solution.structure.parameter_mask(index)
        moved = structure.without_term(index).with_term(model.terms[index])
        return self.fit(moved, model.solution.x[np.argsort(mask, kind="stable")])

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

    def joint_extensions(self, model: FittedModel, joints: Sequence[int]) -> list[FittedModel]:
        """Models in which one effect of `model` acts on one more of the `joints` (from 0), or on all of them."""
        extended = []
        for index, term in enumerate(model.terms):
            possible = term.effect.possible_joints(model.solution.structure.rig)
            missing = tuple(joint for joint in joints if joint in possible and joint not in term.joints)
            if missing and not (term.effect.whole_robot or term.effect.repeated):
                sets = {*((joint,) for joint in missing), missing}
                extended += [self._extend_to_joints(model, index, added) for added in sorted(sets)]
        return extended

    def _extend_to_joints(self, model: FittedModel, index: int, added: Sequence[int]) -> FittedModel:
        """Extend the effect `index` to the joints `added`, starting from the mean of the other joints' parameters."""
        narrow, x = model.solution.structure, model.solution.x
        term, local = model.terms[index], narrow.local_values(index, x)
        joints = tuple(sorted((*term.joints, *added)))
        by_joint = dict(zip(term.joints, local, strict=True))
        values = np.stack([by_joint.get(joint, local.mean(axis=0)) for joint in joints])
        wider = replace(term, joints=joints)
        shapes = narrow.shape_values(index, x)
        if term.effect.local_shapes:
            predictors = [self._split.predictors[i] for i in self._split.train_indices]
            suggested = suggestions(term.effect, predictors, model.solution, model.solution.residuals)
            shapes = wider.shape_guesses(suggested)[0]
        extended = narrow.without_term(index).with_term(wider)
        return self.fit(extended, np.concatenate([x[~narrow.parameter_mask(index)], values.ravel(), shapes]))

    def _refined(self, model: FittedModel, screening: Screening) -> Extensions:
        candidates, excluded, loss_reductions = screening
        return Extensions(
            tuple(self._fit_nonlinear(model, self._significant(model, candidates))), excluded, loss_reductions
        )

    def _screening(self, model: FittedModel) -> Screening:
        """The screening of the whole library for `model`, done once."""
        key = effect_key(model)
        if key not in self._screened:
            self._screened[key] = self.screen(model)
        return self._screened[key]

    def _significant(self, model: FittedModel, candidates: Sequence[Candidate]) -> list[Candidate]:
        return [
            candidate
            for candidate in candidates
            if self.is_significant(model.solution.loss, candidate.loss, candidate.parameter_count)
        ]

    def screen(self, model: FittedModel, skip: str = "") -> Screening:
        """Screen the library for effects that could be added to `model`.

        Returns the candidates, the most promising first; the excluded effects with the reason; and the relative
        reduction of the loss that each candidate promises.
        """
        present = model.names
        library = {
            name: effect
            for name, effect in self._library.items()
            if (name not in present or effect.repeated) and name != skip
        }
        candidates, excluded = Screener(self._split, model.solution).screen(library)
        before = model.solution.loss
        loss_reductions = {candidate.term.name: 1 - candidate.loss / before for candidate in reversed(candidates)}
        return candidates, excluded, loss_reductions

    def candidate(self, model: FittedModel, name: str) -> Candidate | None:
        """The effect `name` as screening finds it beside `model`; None where that shows nothing of it."""
        candidates = Screener(self._split, model.solution).screen({name: self._library[name]})[0]
        return candidates[0] if candidates else None

    def pairs(self, model: FittedModel, loss: float) -> Iterator[FittedModel]:
        """Extensions of `model` by two effects for which screening promises less than `loss`, the best first."""
        candidates = self._screening(model)[0]
        for pair in screen_pairs(Screener(self._split, model.solution), candidates)[:MAX_REFINED]:
            if pair.loss < loss:
                structure, x = model.solution.structure, model.solution.x
                for candidate in pair.effects:
                    structure = structure.with_term(candidate.term)
                    x = np.concatenate([x, candidate.initial_guesses[0]])
                yield self.fit(structure, x)

    def add(self, model: FittedModel, candidate: Candidate) -> FittedModel:
        """Add the `candidate` to `model` and refit all parameters."""
        return self._drop_impossible_joints(self._best_fit(model, candidate), model)

    def _fit_nonlinear(self, model: FittedModel, candidates: Sequence[Candidate]) -> list[FittedModel]:
        """Models with each of the `candidates` that promise enough compared with the best one; the best first."""
        before = model.solution.loss
        models: list[FittedModel] = []
        for candidate in candidates[:MAX_REFINED]:
            best = min((refined.solution.loss for refined in models), default=before)
            if before - candidate.loss < MIN_PROMISE * (before - best) and not _is_further_line(model, candidate):
                continue
            models.append(self.add(model, candidate))
        return sorted(models, key=lambda refined: refined.solution.loss)

    def _best_fit(self, model: FittedModel, candidate: Candidate) -> FittedModel:
        best, before = min(self._fits(model, candidate), key=lambda solution: solution.loss), model.solution.loss
        return FittedModel(self._split, self._split.escape_local_minima(best) if best.loss < before else best)

    def _fits(self, model: FittedModel, candidate: Candidate) -> Iterator[Solution]:
        """Fit `model` with the `candidate` from one initial guess after the other.

        If every start increases the loss, the effect is set to zero. If one start realises what screening promised,
        the others are skipped, except for effects that require a multistart.
        """
        structure = model.solution.structure.with_term(candidate.term)
        before, multistart = model.solution.loss, candidate.term.effect.multistart > 1
        starts = self._initial_fits(model, structure, candidate.initial_guesses)
        if not multistart and min(start.loss for start in starts) > before:
            zeros = np.zeros(len(candidate.initial_guesses[0]) - len(candidate.shapes))
            x = np.concatenate([model.solution.x, zeros, candidate.shapes])
            yield self._split.fit_linear(structure, x)
            return
        for start in starts:
            solution = self._split.fit_nonlinear(start)
            yield solution
            if not multistart and before - solution.loss >= _MIN_REALISED * (before - candidate.loss):
                return

    def _initial_fits(
        self, model: FittedModel, structure: ModelStructure, guesses: Sequence[Floats]
    ) -> Sequence[Solution]:
        """Fit the linear parameters of `structure`, `model` with one more effect, at each of the `guesses` of it.

        If all increase the loss, the nonlinear parameters of `model` move with the effect, as screening assumed.
        """
        starts = in_threads(
            lambda guess: self._split.fit_linear(structure, np.concatenate([model.solution.x, guess])), guesses
        )
        if model.solution.structure.linear.all() or min(start.loss for start in starts) <= model.solution.loss:
            return starts
        of_model = ~structure.parameter_mask(len(structure.terms) - 1)
        moved = in_threads(lambda start: self._split.adapted(start, of_model), starts)
        return [min(pair, key=lambda start: start.loss) for pair in zip(starts, moved, strict=True)]

    def _drop_impossible_joints(self, model: FittedModel, before: FittedModel) -> FittedModel:
        """Remove the joints on which the coefficients of the last effect are outside of their physical limits."""
        term, within = model.terms[-1], within_limits(model)
        possible = [joint for joint, inside in zip(term.joints, within, strict=False) if inside]
        if term.effect.whole_robot or len(term.joints) == 1 or len(possible) in (0, len(term.joints)):
            return model
        structure, index = model.solution.structure, len(model.terms) - 1
        impossible = [joint not in possible for joint in term.joints]
        kept = np.ones(len(model.solution.x), bool)
        kept[structure.instance_entries(index)[impossible]] = False
        values = model.solution.x[structure.parameter_mask(index) & kept]
        reduced = before.solution.structure.with_term(replace(term, joints=tuple(possible)))
        return self.fit(reduced, np.concatenate([before.solution.x, values]))


def _is_further_line(model: FittedModel, candidate: Candidate) -> bool:
    """Whether the candidate is a further line of a spectrum: each line is judged on its own."""
    return candidate.term.effect.repeated and any(term.name == candidate.term.name for term in model.terms)


def effect_key(model: FittedModel) -> _EffectKey:
    """Identify a model by its effects, in any order."""
    return tuple(sorted((term.name, term.joints) for term in model.terms))
