"""What could be added to a model: every effect of the library, looked at, and the promising ones refined."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.diagnosis.screening import Candidate, Screener
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Extensions, FittedModel, Exclusion
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

MAX_REFINED = 8
"""Candidates of each round whose parameters are searched; the others promise too little."""
MIN_PROMISE = 0.4
"""Nor is one that at first sight would gain less than this share of what the best has gained: a search for its
parameters seldom doubles that."""
MIN_SIGNIFICANCE = 15.0
"""Fall of the loss per parameter, over what noise alone makes of it, from which on it counts."""
MIN_SHAPE_EFFECT = 0.01
"""A shape is told by the data if, moved across its range, it changes the residual by more than this share of what is
left, in squares."""
_KEPT = 0.95
"""Share of the gain that the first look promised which a search has to find to be believed."""
_TURNED = 0.1
"""A parameter that cannot be negative may come out so by this share of what it was, by chance."""

_Key = tuple[tuple[str, tuple[int, ...]], ...]
"""The effects of a model, each with its joints."""


class CandidateSearch:
    """Finds the options beyond a model on some material, from a library of effects."""

    def __init__(self, material: SplitData, library: Mapping[str, Effect]) -> None:
        self._material, self._library = material, library
        self._known: dict[_Key, Extensions] = {}
        self._looked: dict[_Key, list[Candidate]] = {}
        """From which the options of these models were found."""

    def extensions(self, state: FittedModel) -> Extensions:
        """All that could be added to `state`."""
        key = effect_key(state)
        if key not in self._known:
            self._known[key] = self._find(state, "")
        return self._known[key]

    def alternatives(self, name: str, without: FittedModel) -> list[FittedModel]:
        """What could be added to `without`, a model that lacks the effect `name`, in its place."""
        known = self._known.get(effect_key(without))
        return [one for one in (known or self._find(without, name)).models if one.terms[-1].name != name]

    def fit(self, composition: Composition, x: Floats) -> FittedModel:
        """`composition` fitted from `x` (K,)."""
        solution = self._material.fit(composition, x)
        return FittedModel(solution, self._material.residuals(solution))

    def chance_reduction(self, loss: float) -> float:
        """Fall of the loss that one more parameter makes by fitting noise."""
        return loss / self._material.independent_rows

    def is_significant(self, before: float, after: float, parameters: int) -> bool:
        """Whether the loss has fallen by more than so many `parameters` make of noise."""
        return before - after > MIN_SIGNIFICANCE * parameters * self.chance_reduction(after)

    def is_redundant(self, name: str, state: FittedModel, other: FittedModel) -> bool:
        """Whether what `other` adds contains the effect `name` of `state`, and explains no more than that."""
        parameters = max(len(other.solution.x) - len(state.solution.x), 0)
        contained = name in other.terms[-1].effect.contains
        return contained and not self.is_significant(state.solution.loss, other.solution.loss, parameters)

    def skipped_extensions(self, state: FittedModel) -> list[FittedModel]:
        """What `options` left out beyond `state`, as it promised too little beside what was found: the best first."""
        known = {one.terms[-1] for one in self.extensions(state).models}
        worth = self._worth(state, self._looked[effect_key(state)])
        others = [one for one in worth if all(one.term.name != term.name for term in known)][:MAX_REFINED]
        return sorted((self.add(state, one) for one in others), key=lambda one: one.solution.loss)

    def joint_extensions(self, state: FittedModel, joints: Sequence[int]) -> list[FittedModel]:
        """`state` with one of its effects on one more of the `joints` (from 0)."""
        return [
            self._widened(state, index, joint)
            for index, term in enumerate(state.terms)
            if not (term.effect.whole_robot or term.effect.repeated)
            for joint in joints
            if joint not in term.joints
        ]

    def _widened(self, state: FittedModel, index: int, joint: int) -> FittedModel:
        """With the effect `index` on one more `joint`, which begins as the others are on the average."""
        before, x = state.solution.composition, state.solution.x
        term, own = state.terms[index], before.own(index, x)
        more = tuple(sorted((*term.joints, joint)))
        values = np.insert(own, more.index(joint), own.mean(axis=0), axis=0)
        wider = before.without(index).plus(replace(term, joints=more))
        return self.fit(
            wider, np.concatenate([x[~before.entries(index)], values.ravel(), before.shapes(index, x)])
        )

    def _find(self, state: FittedModel, leave: str) -> Extensions:
        candidates, unseen, gains = self.screen(state, leave)
        if not leave:
            self._looked[effect_key(state)] = candidates
        return Extensions(tuple(self._refined(state, self._worth(state, candidates))), unseen, gains)

    def _worth(self, state: FittedModel, candidates: Sequence[Candidate]) -> list[Candidate]:
        return [one for one in candidates if self.is_significant(state.solution.loss, one.loss, one.parameter_count)]

    def screen(
        self, state: FittedModel, leave: str = ""
    ) -> tuple[list[Candidate], Mapping[str, Exclusion], Mapping[str, float]]:
        """What could be added, the most promising first; what does not show; what each would gain at first sight."""
        present = {term.name for term in state.terms}
        covered = {name for term in state.terms for name in term.effect.contains}
        library = {
            name: effect
            for name, effect in self._library.items()
            if (name not in present or effect.repeated) and name not in covered and name != leave
        }
        candidates, unseen = Screener(self._material, state.solution).screen(library)
        before = state.solution.loss
        gains = {one.term.name: 1 - one.loss / before for one in reversed(candidates)}
        return candidates, unseen, gains

    def add(self, state: FittedModel, candidate: Candidate) -> FittedModel:
        """`state` with the `candidate`, all parameters refined."""
        return self._signed(self._with(state, candidate), state)

    def _refined(self, state: FittedModel, candidates: Sequence[Candidate]) -> list[FittedModel]:
        """States with each of the `candidates`, as far as they promise anything beside the best, the best first."""
        before = state.solution.loss
        states: list[FittedModel] = []
        for one in candidates[:MAX_REFINED]:
            least = min((found.solution.loss for found in states), default=before)
            if before - one.loss < MIN_PROMISE * (before - least) and not _another(state, one):
                continue
            states.append(self.add(state, one))
        return sorted(states, key=lambda one: one.solution.loss)

    def _with(self, state: FittedModel, candidate: Candidate) -> FittedModel:
        best = min(self._found(state, candidate), key=lambda one: one.loss)
        return FittedModel(best, self._material.residuals(best))

    def _found(self, state: FittedModel, candidate: Candidate) -> Iterator[Solution]:
        """`state` with the `candidate`, from one of its starts after the other, as far as they are worth it.

        What leaves more from each of them than there was without it has not kept what the first look promised, and
        stays at nothing; what has kept that from one of them needs no other; but for landscapes with many valleys.
        """
        composition = state.solution.composition.plus(candidate.term)
        before, many = state.solution.loss, candidate.term.effect.valleys > 1
        begun = [
            self._material.fit_linear(composition, np.concatenate([state.solution.x, one])) for one in candidate.initial_guesses
        ]
        if not many and min(one.loss for one in begun) > before:
            nothing = np.zeros(len(candidate.initial_guesses[0]) - len(candidate.shapes))
            x = np.concatenate([state.solution.x, nothing, candidate.shapes])
            yield self._material.fit_linear(composition, x)
            return
        for one in begun:
            found = self._material.refine(one)
            yield found
            if not many and before - found.loss >= _KEPT * (before - candidate.loss):
                return

    def _signed(self, state: FittedModel, before: FittedModel) -> FittedModel:
        """Without the joints whose coefficients came out beyond what is possible."""
        term, own = state.terms[-1], within_limits(state)
        possible = [joint for joint, inside in zip(term.joints, own, strict=False) if inside]
        if term.effect.whole_robot or len(term.joints) == 1 or len(possible) in (0, len(term.joints)):
            return state
        composition, index = state.solution.composition, len(state.terms) - 1
        owners = [i for i, joint in enumerate(term.joints) if joint in possible]
        values = composition.own(index, state.solution.x)[owners].ravel()
        shapes = composition.shapes(index, state.solution.x)
        fewer = before.solution.composition.plus(replace(term, joints=tuple(possible)))
        return self.fit(fewer, np.concatenate([before.solution.x, values, shapes]))


def within_limits(state: FittedModel) -> list[bool]:
    """For each owner of the last term, whether its own parameters are within their physical range."""
    term = state.terms[-1]
    own = state.solution.composition.own(len(state.terms) - 1, state.solution.x)
    lower, upper = (np.array([getattr(q, side) for q in term.own]) for side in ("lower", "upper"))
    return [bool(((lower <= row) & (row <= upper)).all()) for row in own]


def is_physical(state: FittedModel, before: FittedModel) -> bool:
    """Whether all that the last term of `state` brought is physically possible.

    That is its own parameters, and what became of the mechanism's: an effect that needs friction to help the motion,
    where there was no such thing `before`, is not there.
    """
    parameters = state.solution.composition.mechanism.parameters
    positive = np.array([parameter.physically_positive for parameter in parameters])
    now, then = (one.solution.x[: len(parameters)] for one in (state, before))
    turned = positive & (then >= 0) & (now < -_TURNED * np.abs(then))
    return all(within_limits(state)) and not turned.any() and not _at_the_end(state)


def _at_the_end(state: FittedModel) -> bool:
    """Whether the search for a shape has run into the end of its range where that is not physical any more.

    A shape that these data do not tell may be anywhere.
    """
    term, index = state.terms[-1], len(state.terms) - 1
    shapes = zip(term.effect.shapes, state.solution.composition.shapes(index, state.solution.x), strict=True)
    first = len(state.solution.x) - len(term.effect.shapes)
    return any(
        ((one.open == "upper" and value >= one.upper) or (one.open == "lower" and value <= one.lower))
        and _told(state, entry, one.upper - one.lower)
        for entry, (one, value) in enumerate(shapes, start=first)
    )


def _told(state: FittedModel, entry: int, span: float) -> bool:
    """Whether the loss depends on an `entry` of the parameter vector, anywhere in its `span`."""
    pairs = zip(state.solution.weights, state.solution.derivatives, strict=True)
    changed = sum(float(np.nansum((weight * by_x[:, :, entry] * span) ** 2)) for weight, by_x in pairs)
    return changed > MIN_SHAPE_EFFECT * state.solution.loss


def _another(state: FittedModel, candidate: Candidate) -> bool:
    """Whether this is one more line of a spectrum of which the model has some: each is judged for itself."""
    return candidate.term.effect.repeated and any(term.name == candidate.term.name for term in state.terms)


def effect_key(state: FittedModel) -> _Key:
    """What tells models apart: their effects, in any order."""
    return tuple(sorted((term.name, term.joints) for term in state.terms))
