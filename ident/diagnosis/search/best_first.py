"""One best-first search over models: several stay open, so that a wrong first step costs nothing.

States are models, each fitted once. The neighbours of a model have one effect more, one less, or the same one on
other joints. The best model by `judge.price.score` is expanded, and while it leaves much, the next ones are, too. The
answer is the best model in which the judge accepts every effect beside all the others.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import judge
from ident.diagnosis.judge.price import PRICE, score
from ident.diagnosis.judge.rules import OF_VALUES, objection
from ident.diagnosis.judge.rules.strength import wald_statistic
from ident.diagnosis.search.candidates import Candidates, Key, added_term, key_of
from ident.diagnosis.search.selection import WIDTH
from ident.diagnosis.split.split_data import rms
from ident.dynamics.structure import Term
from recordings.recording import Ints

MAX_EFFECTS = 5
"""Most effects, by name, that are added: a robot that lacks more than a handful lacks one that is in no library."""
Names = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class State:
    """A model that was found."""

    model: FittedModel

    @cached_property
    def names(self) -> Names:
        """The effects of the model, whatever their joints."""
        return tuple(sorted(term.name for term in self.model.terms))

    @cached_property
    def score(self) -> float:
        """The smaller the better."""
        return score(self.model)


class BestFirst:
    """The models found so far, and how the search goes on."""

    def __init__(self, candidates: Candidates, progress: Callable[[str], None]) -> None:
        self._candidates, self._fits, self._progress = candidates, candidates.fits, progress
        self._states: dict[Key, State | None] = {}
        """None: an effect of the model pays on some of its joints alone."""
        self._expanded: set[Names] = set()
        self._refused: dict[Key, int | None] = {}

    def search(self, start: FittedModel) -> FittedModel:
        """The best model that is reached from `start` and accepted."""
        self._start = start
        self._insert(start)
        while True:
            while (state := self._next()) is not None:
                self._expand(state)
            answer = self._answer()
            if not self._is_open(answer):  # what is accepted need not be among the best
                return answer.model
            self._expand(answer)

    def _ranked(self) -> Iterator[State]:
        """The models, the best first, and the best one of those that differ in joints only."""
        best: dict[Names, State] = {}
        for state in sorted(filter(None, self._states.values()), key=lambda state: state.score):
            best.setdefault(state.names, state)
        yield from best.values()

    def _next(self) -> State | None:
        """The best of the open states that are worth their expansion."""
        ranked = self._ranked()
        best = next(ranked)
        worth = [best, *(islice(ranked, WIDTH - 1) if joints_that_leave_much(best.model) else ())]
        return next(filter(self._is_open, worth), None)

    def _is_open(self, state: State) -> bool:
        return len({*state.names} - self._start.names) < MAX_EFFECTS and state.names not in self._expanded

    def _expand(self, state: State) -> None:
        self._expanded.add(state.names)
        model = state.model
        names = ", ".join(term.name for term in model.terms if not term.effect.mandatory)
        self._progress(f"{names or 'base model'}: trying every other effect beside it")
        for other in [*self._candidates.extensions(model), *self._wider(model)]:
            if (model is self._start or _is_large(model, other)) and (
                objection(OF_VALUES, model, other, added_term(model, other)) is None
            ):
                self._insert(other)
        for smaller in self._smaller(model):
            self._insert(smaller)

    def _insert(self, model: FittedModel) -> bool:
        """Keep a `model`; whether it is new."""
        key = key_of(model.solution.structure, model.solution.x)
        new = key not in self._states
        if new or self._states[key]:
            self._states[key] = State(model)
        return new

    def _wider(self, model: FittedModel) -> Iterator[FittedModel]:
        """Models in which one effect of `model` acts on one more joint that leaves much, or on all of them."""
        joints = joints_that_leave_much(model)
        for index, term in enumerate(model.terms):
            possible = term.effect.possible_joints(model.solution.structure.rig)
            missing = tuple(joint for joint in joints if joint in possible and joint not in term.joints)
            if missing and not (term.effect.whole_robot or term.effect.repeated):
                for added in sorted({*((joint,) for joint in missing), missing}):
                    wider = self._fits.on_joints(model, index, sorted((*term.joints, *added)))
                    yield self._on_paying_joints(wider, index)

    def _smaller(self, model: FittedModel) -> Iterator[FittedModel]:
        """Models with one effect, or one joint of an effect, less, where it is worth less than its parameters.

        An effect that tells joints from each other may act on the other joints instead.
        """
        structure = model.solution.structure
        for index, term in enumerate(model.terms):
            if term.effect.mandatory:
                continue
            if _price_ratio(model, np.flatnonzero(structure.parameter_mask(index))) < 1:
                yield self._fits.without_effect(model, index)
            yield from self._contained(model, index)
            if len(term.joints) == 1 or term.effect.whole_robot:
                continue
            for joint, own in zip(term.joints, structure.instance_entries(index), strict=True):
                if _price_ratio(model, own) < 1:
                    yield self._fits.on_joints(model, index, [other for other in term.joints if other != joint])
            others = [joint for joint in term.effect.possible_joints(structure.rig) if joint not in term.joints]
            if term.effect.differential and 0 < len(others) < len(term.joints):
                yield self._fits.on_joints(model, index, others)

    def _contained(self, model: FittedModel, index: int) -> Iterator[FittedModel]:
        """Models in which an effect that the effect `index` of `model` contains stands in its place."""
        term, library = model.terms[index], self._candidates.library
        for name in sorted({*term.effect.contains} & library.keys()):
            bare = self._fits.without_effect(model, index)
            present = next((i for i, other in enumerate(bare.terms) if other.name == name), None)
            if present is None:
                yield self._fits.with_term(bare, Term(name, library[name], term.joints))
            else:
                yield self._fits.on_joints(bare, present, sorted({*bare.terms[present].joints, *term.joints}))

    def _answer(self) -> State:
        """The best model in which every effect is accepted; one without the weakest that is not, is one, too.

        An effect that pays on some of its joints alone is judged there.
        """
        refused: set[Names] = set()
        while True:
            state = next(each for each in self._ranked() if each.names not in refused)
            model = state.model
            if (index := self._refused_effect(model)) is None:
                # A joint that paid while another effect was missing may be worth nothing beside it.
                if any(self._insert(smaller) for smaller in self._smaller(model)):
                    continue
                return state
            if (moved := self._on_paying_joints(model, index)) is not model:
                self._states[key_of(model.solution.structure, model.solution.x)] = None
                self._insert(moved)
                continue
            refused.add(state.names)
            self._insert(self._fits.without_effect(model, index))

    def _on_paying_joints(self, model: FittedModel, index: int) -> FittedModel:
        """`model` with its effect number `index` where it pays beside all others."""
        return self._fits.on_paying_joints(self._fits.without_effect(model, index), model, index)

    def _refused_effect(self, model: FittedModel) -> int | None:
        """Number of the weakest effect of `model` that the judge does not accept beside all the others."""
        key = key_of(model.solution.structure, model.solution.x)
        if key not in self._refused:
            self._refused[key] = next(
                (
                    index
                    for index in _by_strength(model)
                    if not judge(self._fits.without_effect(model, index), model, index).accepted
                ),
                None,
            )
        return self._refused[key]


def _is_large(model: FittedModel, other: FittedModel) -> bool:
    """Whether `other` explains much of what `model` leaves: many small effects imitate any unknown."""
    return not all(other.improvement_over(model, rows).is_small for rows in (model.split.train, model.split.test))


def joints_that_leave_much(model: FittedModel) -> list[int]:
    """Joints (from 0) on which the error of `model` is above what a correct one may leave."""
    error = np.maximum(*(rms(model.judged_residuals, rows) for rows in (model.split.train, model.split.test)))
    return np.flatnonzero(error > model.noise_floor.limit).tolist()


def _by_strength(model: FittedModel) -> list[int]:
    """Numbers of the effects of `model` that not every robot has, the weakest first."""
    optional = [index for index, term in enumerate(model.terms) if not term.effect.mandatory]
    return sorted(
        optional,
        key=lambda index: _price_ratio(model, np.flatnonzero(model.solution.structure.parameter_mask(index))),
    )


def _price_ratio(model: FittedModel, entries: Ints) -> float:
    """What the parameters `entries` take of the loss, by Wald's statistic, relative to their price."""
    return wald_statistic(model.solution.x[entries], model.uncertainty.covariance, entries) / (PRICE * len(entries))
