"""The ladder: add the effect that explains most, refit everything, ask again, until nothing is left to explain."""

from collections.abc import Callable, Mapping, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from ident.diagnosis.candidate_search import MIN_SIGNIFICANCE, CandidateSearch, effect_key, is_physical
from ident.diagnosis.improvement import Improvement, measure_improvement
from ident.diagnosis.noise_floor import NoiseFloor, estimate_noise_floor
from ident.diagnosis.split_data import SplitData, rms
from ident.diagnosis.steps import Finding, Selection, Extensions, SelectionStep, FittedModel
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition, Term
from recordings.errors import BadInput
from recordings.recording import Floats

MAX_EFFECTS = 16
"""Effects that are added at most."""
MAX_ROUNDS = 3
"""Times that effects already found are put to the question again."""
EQUIVALENT_SHARE = 0.04
"""Candidates whose gains differ by less than this share of it explain the same."""
MIN_T = 3.5
"""Student's t of the held-out fall from which on it counts; all the candidates were tried."""
MIN_LOWER_BOUND = 0.1
"""Lower end of the interval of the held-out gain from which on it counts, too."""
MIN_DECISIVE_SHARE = 0.5
"""Share of what another explanation leaves above the floor that, once taken away, speaks against it."""
MIN_DECISIVE_REDUCTION = 0.05
"""Fall of the mean square, over that of the floor, that speaks for nothing: the floor is no better known."""
MIN_KEPT_SHARE = 0.05
"""Share of what is above the floor, without an effect, that makes it stay in the model."""
MIN_ADDED_SHARE = 0.15
"""Share of what is above the floor below which an effect is not added while much is left that it does not explain."""
LARGE_EXCESS = 3.0
"""Mean square above the floor that is much, over that of the floor."""
MAX_ALTERNATIVE_RATIO = 0.5
"""Another way up is better if it leaves less than this share of what the first one leaves above the floor."""
MAX_FLOOR_RATIO = 1.1
"""A joint that leaves more than so many times its floor may have what others have."""
MIN_TORQUE_SHARE = 0.002
"""What changes the residual by less than this share of the torque is left alone."""


def is_supported(found: Improvement) -> bool:
    """Whether held-out rows bear a gain out: everywhere a little, or much, though perhaps at few places."""
    return found.t_statistic > MIN_T or found.interval[0] > MIN_LOWER_BOUND


def is_decisive(found: Improvement) -> bool:
    """Whether it speaks against what explains nearly as much."""
    return found.t_statistic > MIN_T and found.share > MIN_DECISIVE_SHARE and found.reduction > MIN_DECISIVE_REDUCTION


class Selector:
    """Climbs the ladder on some material with a library of effects."""

    def __init__(self, material: SplitData, library: Mapping[str, Effect], progress: Callable[[str], None]) -> None:
        self._material, self._library, self._progress = material, library, progress
        self.search = CandidateSearch(material, library)
        self._floors: WeakKeyDictionary[FittedModel, NoiseFloor] = WeakKeyDictionary()

    def select(self, composition: Composition, x: Floats) -> Selection:
        """From `composition` upwards, fitted from `x` (K,)."""
        state, rungs = self.start(composition, x)
        first = self.search.extensions(state)
        ladder = self._complete(state, list(rungs), first)
        last = ladder.steps[-1].model
        way = self._other_way(state, first, last) if self._left(last) > LARGE_EXCESS else None
        if way is None:
            return ladder
        rungs.append(SelectionStep(way.terms[-1].name, way, self.improvement(rungs[-1].model, way)))
        other = self._complete(way, rungs, first)
        return other if self._far_better(other.steps[-1].model, last) else ladder

    def _complete(self, state: FittedModel, rungs: list[SelectionStep], first: Extensions) -> Selection:
        """From `state`, where `rungs` end, as far up as it goes."""
        for _ in range(MAX_ROUNDS):
            state, last = self._up(state, rungs)
            looked = [self._look_again(state, index) for index in range(len(state.terms))]
            better = next((found for _, found in looked if found is not state), None)
            if better is None:
                break
            state = self._settled(better)
            rungs.append(SelectionStep(better.terms[-1].name, state, self.improvement(rungs[-1].model, state)))
        findings = tuple(finding for finding, _ in looked)
        return Selection(tuple(rungs), findings, first, last, self.noise_floor(state), self._computed(state))

    def _other_way(self, state: FittedModel, first: Extensions, last: FittedModel) -> FittedModel | None:
        """Another effect to begin with beyond `state`, where the way up ended at `last` with much left.

        What explains most may imitate two effects together, and beside it neither of them finds its place. So it is
        the second step that tells which first one was right.
        """
        self._progress("much is left; what if it began otherwise?")
        taken, seconds = {term.name for term in last.terms}, []
        for way in first.models:
            if way.terms[-1].name in taken or not is_physical(way, state) or not self._promising(state, way):
                continue
            second = self._first_confirmed(way, self.search.extensions(way).models)
            if second is not None and self._far_better(second, last) and self._confirmed(state, second):
                seconds.append((second.solution.loss, way))
        return min(seconds, key=lambda one: one[0])[1] if seconds else None

    def _promising(self, state: FittedModel, way: FittedModel) -> bool:
        """Whether held-out rows bear `way` out, or it explains so much that they may once something is beside it."""
        return self._confirmed(state, way) or way.solution.loss < MAX_ALTERNATIVE_RATIO * state.solution.loss

    def _far_better(self, state: FittedModel, other: FittedModel) -> bool:
        return self._left(state) < MAX_ALTERNATIVE_RATIO * self._left(other)

    def _left(self, state: FittedModel) -> float:
        """Held-out mean square above the floor that `state` leaves, over that of the floor."""
        return self.improvement(state, state).remaining

    def start(self, composition: Composition, x: Floats) -> tuple[FittedModel, list[SelectionStep]]:
        """The state with all that is true anyway, fitted from `x` (K,), and the first rungs."""
        base = self.search.fit(composition, x)
        rungs = [SelectionStep(None, base, None)]
        return self._with_truths(base, rungs), rungs

    def select_forced(self, composition: Composition, x: Floats, names: Sequence[str]) -> Selection:
        """From `composition` upwards, fitted from `x` (K,), by the effects `names` in this order, and no others.

        Raises:
            BadInput: the motion does not show one of them.
        """
        state, rungs = self.start(composition, x)
        for name in names:
            candidates, unseen, _ = self.search.screen(state)
            found = {one.term.name: one for one in reversed(candidates)}
            if name not in found:
                known = name in {term.name for term in state.terms}
                why = "is in the model already" if known else "does not show in this motion"
                why = "is not there: it would need a sign that it cannot have" if unseen.get(name) == "sign" else why
                raise BadInput(f"effect: one of {', '.join(sorted(found))} expected; '{name}' {why}; leave it out")
            state = self.search.add(state, found[name])
            rungs.append(SelectionStep(name, state, self.improvement(rungs[-1].model, state)))
        last = Extensions((), *self.search.screen(state)[1:])
        findings = tuple(self._look_again(state, index)[0] for index in range(len(state.terms)))
        return Selection(tuple(rungs), findings, last, last, self.noise_floor(state), self._computed(state))

    def truncated(self, ladder: Selection, number: int) -> Selection:
        """The `ladder` up to the rung of that `number`."""
        state = ladder.steps[number].model
        findings = tuple(self._look_again(state, index)[0] for index in range(len(state.terms)))
        last = self.search.extensions(state)
        rungs = ladder.steps[: number + 1]
        return Selection(rungs, findings, ladder.first_extensions, last, self.noise_floor(state), self._computed(state))

    def _up(self, state: FittedModel, rungs: list[SelectionStep]) -> tuple[FittedModel, Extensions]:
        """The state when nothing more is worth adding, and what could be added still."""
        been = {effect_key(state)}
        while True:
            found = self.search.extensions(state)
            chosen = self._chosen(state, found.models) if len(state.terms) < MAX_EFFECTS else None
            if chosen is None:
                return state, found
            state = self._settled(chosen)
            if effect_key(state) in been:  # what was added makes itself superfluous
                return state, found
            been.add(effect_key(state))
            rungs.append(SelectionStep(chosen.terms[-1].name, state, self.improvement(rungs[-1].model, state)))
            self._progress(f"{rungs[-1].added} added; what else?")

    def noise_floor(self, state: FittedModel) -> NoiseFloor:
        """The line to reach."""
        if state not in self._floors:
            self._floors[state] = estimate_noise_floor(self._material, state.solution, state.residuals)
        return self._floors[state]

    def _computed(self, state: FittedModel) -> tuple[Floats, ...]:
        pairs = zip(self._material.datasets, state.residuals, strict=True)
        return tuple(data.torque - residual for data, residual in pairs)

    def _with_truths(self, state: FittedModel, rungs: list[SelectionStep]) -> FittedModel:
        """With what is true of any such machine, whatever its coefficient: other effects may still disturb it."""
        joints = tuple(range(state.solution.composition.rig.dof))
        known = [term.name for term in state.terms]
        for name, effect in self._library.items():
            if not effect.always_true or name in known:
                continue
            composition = state.solution.composition.plus(Term(name, effect, joints))
            added = np.zeros(len(composition.named) - len(state.solution.x))
            after = self.search.fit(composition, np.concatenate([state.solution.x, added]))
            if self._confirmed(state, after):
                rungs.append(SelectionStep(name, after, self.improvement(state, after)))
            state = after
        return state

    def _chosen(self, state: FittedModel, options: Sequence[FittedModel]) -> FittedModel | None:
        """The next effect. What explains most may not hold before a smaller one beside it is known."""
        seen, least = rms(state.residuals, self._material.train), self.noise_floor(state).rms
        # A right model would leave no less. What lowers the errors below that fits what encoders' steps make.
        if self._left(state) <= 0 or (seen <= least).all():
            return None
        short = np.flatnonzero(seen > MAX_FLOOR_RATIO * least)
        options = [*options, *self.search.joint_extensions(state, short.tolist())]
        found = self._first_confirmed(state, options)
        return found or (self._first_confirmed(state, self.search.skipped_extensions(state)) if options else None)

    def _first_confirmed(self, state: FittedModel, options: Sequence[FittedModel]) -> FittedModel | None:
        """The simplest of those that explain most, if rows that no fit saw bear it out; else the next ones."""
        options = [one for one in options if is_physical(one, state)]
        while options:
            best = self._simplest(state, options)
            if self._confirmed(state, best) and not self._crumb(state, best):
                return best
            options = [one for one in options if one is not best]
        return None

    def _simplest(self, state: FittedModel, options: Sequence[FittedModel]) -> FittedModel:
        """Of those that explain as much as the best, unless held-out rows clearly speak for another of them."""
        alike = self._alike(state.solution.loss, options)
        simplest = min(alike, key=lambda one: (len(one.solution.x), one.solution.loss))
        return next((one for one in alike if self._settles(simplest, one)), simplest)

    def _alike(self, without: float, options: Sequence[FittedModel]) -> list[FittedModel]:
        """Those that leave no more than the best, but for chance and a small share of what there is to gain."""
        least = min(one.solution.loss for one in options)
        slack = max(EQUIVALENT_SHARE * (without - least), MIN_SIGNIFICANCE * self.search.chance_reduction(least))
        return [one for one in options if one.solution.loss - least <= slack]

    def _confirmed(self, before: FittedModel, after: FittedModel) -> bool:
        """Whether the last effect of `after` explains something, on the rows seen and on those held out."""
        parameters = len(after.solution.x) - len(before.solution.x)
        changed = [b - a for b, a in zip(before.residuals, after.residuals, strict=True)]
        size = np.sqrt([np.nanmean(np.concatenate(changed) ** 2, axis=0)])
        return (
            self.search.is_significant(before.solution.loss, after.solution.loss, parameters)
            and bool((size > MIN_TORQUE_SHARE * self._material.torque_rms).any())
            and is_supported(self.improvement(before, after))
        )

    def _crumb(self, before: FittedModel, after: FittedModel) -> bool:
        """Whether `after` explains little of much that is not understood.

        Anything of which the library knows nothing can be put together of many such pieces, none of which is there.
        """
        found = self.improvement(before, after)
        return found.share < MIN_ADDED_SHARE and found.remaining > LARGE_EXCESS

    def improvement(self, before: FittedModel, after: FittedModel) -> Improvement:
        """What `after` has gained over `before` on held-out rows."""
        return measure_improvement(self._material, before.residuals, after.residuals, self.noise_floor(after).rms)

    def _settled(self, state: FittedModel) -> FittedModel:
        """Without effects that the last one has made superfluous, nor the last one where the others do without it."""
        for index in range(len(state.terms) - 1, -1, -1):
            if state.terms[index].effect.always_true:
                continue
            without = self.without_effect(state, index)
            if self.improvement(without, state).share < MIN_KEPT_SHARE and not self._confirmed(without, state):
                state = without
        return state

    def without_effect(self, state: FittedModel, index: int) -> FittedModel:
        """`state` without its effect of that `index`, refitted."""
        composition = state.solution.composition
        keep = ~composition.entries(index)
        return self.search.fit(composition.without(index), state.solution.x[keep])

    def _settles(self, other: FittedModel, state: FittedModel) -> bool:
        """Whether rows speak for `state` against an `other` that explains nearly as much.

        Those held out; or all, for the motion that tells the two apart may be among those that were fitted. It has
        to be more then than the parameters that `state` has more would make of noise.
        """
        if is_decisive(self.improvement(other, state)):
            return True
        parameters = max(len(state.solution.x) - len(other.solution.x), 1)
        if not self.search.is_significant(other.solution.loss, state.solution.loss, parameters):
            return False
        found = measure_improvement(self._material, other.residuals, state.residuals, self.noise_floor(state).rms, self._material.scored)
        return is_decisive(found)

    def _look_again(self, state: FittedModel, index: int) -> tuple[Finding, FittedModel]:
        """The effect, what it is worth, and what could stand in its place; and the state with what should."""
        without = self.without_effect(state, index)
        term = state.terms[index]
        gain = self.improvement(without, state)
        lines = sum(other.name == term.name for other in state.terms)
        if term.effect.always_true or lines > 1:  # one line of a spectrum has no other explanation than the others
            return Finding(term, gain, (), without.residuals, state.residuals), state
        options = self.search.alternatives(term.name, without)
        others = [one for one in options if is_physical(one, without)]
        alike = self._alike(without.solution.loss, [state, *others])
        best = self._simplest(without, [state, *others])
        if best is not state and not self._confirmed(without, best):
            best = state
        names = [
            one.terms[-1].name
            for one in alike
            if one is not state and not self._settles(one, state) and not self.search.is_redundant(term.name, state, one)
        ]
        names = names if any(one is state for one in alike) else []  # what explains far more is no other name for it
        return Finding(term, gain, tuple(names[:3]), without.residuals, state.residuals), best
