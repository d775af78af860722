"""The ladder: add the effect that explains most, refit everything, ask again, until nothing is left to explain."""

from collections.abc import Callable, Mapping, Sequence
from weakref import WeakKeyDictionary

import numpy as np

from ident.diagnosis.candidate_search import CLEAR, Finder, key_of, possible
from ident.diagnosis.improvement import Gain, gain
from ident.diagnosis.noise_floor import Floor, floor
from ident.diagnosis.split_data import Material, rms
from ident.diagnosis.steps import Finding, Ladder, Options, Rung, State
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition, Term
from recordings.errors import BadInput
from recordings.recording import Floats

MOST = 16
"""Effects that are added at most."""
ROUNDS = 3
"""Times that effects already found are put to the question again."""
ALIKE = 0.04
"""Candidates whose gains differ by less than this share of it explain the same."""
CERTAIN = 3.5
"""Student's t of the held-out fall from which on it counts; all the candidates were tried."""
SURE = 0.1
"""Lower end of the interval of the held-out gain from which on it counts, too."""
SETTLED = 0.5
"""Share of what another explanation leaves above the floor that, once taken away, speaks against it."""
UNSURE = 0.05
"""Fall of the mean square, over that of the floor, that speaks for nothing: the floor is no better known."""
WORTH = 0.05
"""Share of what is above the floor, without an effect, that makes it stay in the model."""
CRUMB = 0.15
"""Share of what is above the floor below which an effect is not added while much is left that it does not explain."""
MUCH = 3.0
"""Mean square above the floor that is much, over that of the floor."""
FAR = 0.5
"""Another way up is better if it leaves less than this share of what the first one leaves above the floor."""
LACKING = 1.1
"""A joint that leaves more than so many times its floor may have what others have."""
MATERIAL = 0.002
"""What changes the residual by less than this share of the torque is left alone."""


def holds(found: Gain) -> bool:
    """Whether held-out rows bear a gain out: everywhere a little, or much, though perhaps at few places."""
    return found.t > CERTAIN or found.interval[0] > SURE


def settles(found: Gain) -> bool:
    """Whether it speaks against what explains nearly as much."""
    return found.t > CERTAIN and found.share > SETTLED and found.fall > UNSURE


class Climber:
    """Climbs the ladder on some material with a library of effects."""

    def __init__(self, material: Material, library: Mapping[str, Effect], progress: Callable[[str], None]) -> None:
        self._material, self._library, self._progress = material, library, progress
        self.finder = Finder(material, library)
        self._floors: WeakKeyDictionary[State, Floor] = WeakKeyDictionary()

    def climb(self, composition: Composition, x: Floats) -> Ladder:
        """From `composition` upwards, fitted from `x` (K,)."""
        state, rungs = self.begin(composition, x)
        first = self.finder.options(state)
        ladder = self._complete(state, list(rungs), first)
        last = ladder.rungs[-1].state
        way = self._other_way(state, first, last) if self._left(last) > MUCH else None
        if way is None:
            return ladder
        rungs.append(Rung(way.terms[-1].name, way, self.gain(rungs[-1].state, way)))
        other = self._complete(way, rungs, first)
        return other if self._far_better(other.rungs[-1].state, last) else ladder

    def _complete(self, state: State, rungs: list[Rung], first: Options) -> Ladder:
        """From `state`, where `rungs` end, as far up as it goes."""
        for _ in range(ROUNDS):
            state, last = self._up(state, rungs)
            looked = [self._look_again(state, index) for index in range(len(state.terms))]
            better = next((found for _, found in looked if found is not state), None)
            if better is None:
                break
            state = self._settled(better)
            rungs.append(Rung(better.terms[-1].name, state, self.gain(rungs[-1].state, state)))
        findings = tuple(finding for finding, _ in looked)
        return Ladder(tuple(rungs), findings, first, last, self.floor(state), self._computed(state))

    def _other_way(self, state: State, first: Options, last: State) -> State | None:
        """Another effect to begin with beyond `state`, where the way up ended at `last` with much left.

        What explains most may imitate two effects together, and beside it neither of them finds its place. So it is
        the second step that tells which first one was right.
        """
        self._progress("much is left; what if it began otherwise?")
        taken, seconds = {term.name for term in last.terms}, []
        for way in first.states:
            if way.terms[-1].name in taken or not possible(way, state) or not self._promising(state, way):
                continue
            second = self._first_confirmed(way, self.finder.options(way).states)
            if second is not None and self._far_better(second, last) and self._confirmed(state, second):
                seconds.append((second.solution.loss, way))
        return min(seconds, key=lambda one: one[0])[1] if seconds else None

    def _promising(self, state: State, way: State) -> bool:
        """Whether held-out rows bear `way` out, or it explains so much that they may once something is beside it."""
        return self._confirmed(state, way) or way.solution.loss < FAR * state.solution.loss

    def _far_better(self, state: State, other: State) -> bool:
        return self._left(state) < FAR * self._left(other)

    def _left(self, state: State) -> float:
        """Held-out mean square above the floor that `state` leaves, over that of the floor."""
        return self.gain(state, state).left

    def begin(self, composition: Composition, x: Floats) -> tuple[State, list[Rung]]:
        """The state with all that is true anyway, fitted from `x` (K,), and the first rungs."""
        base = self.finder.solved(composition, x)
        rungs = [Rung(None, base, None)]
        return self._with_truths(base, rungs), rungs

    def by_hand(self, composition: Composition, x: Floats, names: Sequence[str]) -> Ladder:
        """From `composition` upwards, fitted from `x` (K,), by the effects `names` in this order, and no others.

        Raises:
            BadInput: the motion does not show one of them.
        """
        state, rungs = self.begin(composition, x)
        for name in names:
            candidates, unseen, _ = self.finder.look(state)
            found = {one.term.name: one for one in reversed(candidates)}
            if name not in found:
                known = name in {term.name for term in state.terms}
                why = "is in the model already" if known else "does not show in this motion"
                why = "is not there: it would need a sign that it cannot have" if unseen.get(name) == "sign" else why
                raise BadInput(f"effect: one of {', '.join(sorted(found))} expected; '{name}' {why}; leave it out")
            state = self.finder.added(state, found[name])
            rungs.append(Rung(name, state, self.gain(rungs[-1].state, state)))
        last = Options((), *self.finder.look(state)[1:])
        findings = tuple(self._look_again(state, index)[0] for index in range(len(state.terms)))
        return Ladder(tuple(rungs), findings, last, last, self.floor(state), self._computed(state))

    def stopped(self, ladder: Ladder, number: int) -> Ladder:
        """The `ladder` up to the rung of that `number`."""
        state = ladder.rungs[number].state
        findings = tuple(self._look_again(state, index)[0] for index in range(len(state.terms)))
        last = self.finder.options(state)
        rungs = ladder.rungs[: number + 1]
        return Ladder(rungs, findings, ladder.first, last, self.floor(state), self._computed(state))

    def _up(self, state: State, rungs: list[Rung]) -> tuple[State, Options]:
        """The state when nothing more is worth adding, and what could be added still."""
        been = {key_of(state)}
        while True:
            found = self.finder.options(state)
            chosen = self._chosen(state, found.states) if len(state.terms) < MOST else None
            if chosen is None:
                return state, found
            state = self._settled(chosen)
            if key_of(state) in been:  # what was added makes itself superfluous
                return state, found
            been.add(key_of(state))
            rungs.append(Rung(chosen.terms[-1].name, state, self.gain(rungs[-1].state, state)))
            self._progress(f"{rungs[-1].added} added; what else?")

    def floor(self, state: State) -> Floor:
        """The line to reach."""
        if state not in self._floors:
            self._floors[state] = floor(self._material, state.solution, state.residuals)
        return self._floors[state]

    def _computed(self, state: State) -> tuple[Floats, ...]:
        pairs = zip(self._material.datasets, state.residuals, strict=True)
        return tuple(data.torque - residual for data, residual in pairs)

    def _with_truths(self, state: State, rungs: list[Rung]) -> State:
        """With what is true of any such machine, whatever its coefficient: other effects may still disturb it."""
        joints = tuple(range(state.solution.composition.rig.dof))
        known = [term.name for term in state.terms]
        for name, effect in self._library.items():
            if not effect.always_true or name in known:
                continue
            composition = state.solution.composition.plus(Term(name, effect, joints))
            added = np.zeros(len(composition.named) - len(state.solution.x))
            after = self.finder.solved(composition, np.concatenate([state.solution.x, added]))
            if self._confirmed(state, after):
                rungs.append(Rung(name, after, self.gain(state, after)))
            state = after
        return state

    def _chosen(self, state: State, options: Sequence[State]) -> State | None:
        """The next effect. What explains most may not hold before a smaller one beside it is known."""
        seen, least = rms(state.residuals, self._material.seen), self.floor(state).rms
        # A right model would leave no less. What lowers the errors below that fits what encoders' steps make.
        if self._left(state) <= 0 or (seen <= least).all():
            return None
        short = np.flatnonzero(seen > LACKING * least)
        options = [*options, *self.finder.wider(state, short.tolist())]
        found = self._first_confirmed(state, options)
        return found or (self._first_confirmed(state, self.finder.unlikely(state)) if options else None)

    def _first_confirmed(self, state: State, options: Sequence[State]) -> State | None:
        """The simplest of those that explain most, if rows that no fit saw bear it out; else the next ones."""
        options = [one for one in options if possible(one, state)]
        while options:
            best = self._simplest(state, options)
            if self._confirmed(state, best) and not self._crumb(state, best):
                return best
            options = [one for one in options if one is not best]
        return None

    def _simplest(self, state: State, options: Sequence[State]) -> State:
        """Of those that explain as much as the best, unless held-out rows clearly speak for another of them."""
        alike = self._alike(state.solution.loss, options)
        simplest = min(alike, key=lambda one: (len(one.solution.x), one.solution.loss))
        return next((one for one in alike if self._settles(simplest, one)), simplest)

    def _alike(self, without: float, options: Sequence[State]) -> list[State]:
        """Those that leave no more than the best, but for chance and a small share of what there is to gain."""
        least = min(one.solution.loss for one in options)
        slack = max(ALIKE * (without - least), CLEAR * self.finder.chance(least))
        return [one for one in options if one.solution.loss - least <= slack]

    def _confirmed(self, before: State, after: State) -> bool:
        """Whether the last effect of `after` explains something, on the rows seen and on those held out."""
        parameters = len(after.solution.x) - len(before.solution.x)
        changed = [b - a for b, a in zip(before.residuals, after.residuals, strict=True)]
        size = np.sqrt([np.nanmean(np.concatenate(changed) ** 2, axis=0)])
        return (
            self.finder.clear(before.solution.loss, after.solution.loss, parameters)
            and bool((size > MATERIAL * self._material.torque_rms).any())
            and holds(self.gain(before, after))
        )

    def _crumb(self, before: State, after: State) -> bool:
        """Whether `after` explains little of much that is not understood.

        Anything of which the library knows nothing can be put together of many such pieces, none of which is there.
        """
        found = self.gain(before, after)
        return found.share < CRUMB and found.left > MUCH

    def gain(self, before: State, after: State) -> Gain:
        """What `after` has gained over `before` on held-out rows."""
        return gain(self._material, before.residuals, after.residuals, self.floor(after).rms)

    def _settled(self, state: State) -> State:
        """Without effects that the last one has made superfluous, nor the last one where the others do without it."""
        for index in range(len(state.terms) - 1, -1, -1):
            if state.terms[index].effect.always_true:
                continue
            without = self.without(state, index)
            if self.gain(without, state).share < WORTH and not self._confirmed(without, state):
                state = without
        return state

    def without(self, state: State, index: int) -> State:
        """`state` without its effect of that `index`, refitted."""
        composition = state.solution.composition
        keep = ~composition.entries(index)
        return self.finder.solved(composition.without(index), state.solution.x[keep])

    def _settles(self, other: State, state: State) -> bool:
        """Whether rows speak for `state` against an `other` that explains nearly as much.

        Those held out; or all, for the motion that tells the two apart may be among those that were fitted. It has
        to be more then than the parameters that `state` has more would make of noise.
        """
        if settles(self.gain(other, state)):
            return True
        parameters = max(len(state.solution.x) - len(other.solution.x), 1)
        if not self.finder.clear(other.solution.loss, state.solution.loss, parameters):
            return False
        found = gain(self._material, other.residuals, state.residuals, self.floor(state).rms, self._material.judged)
        return settles(found)

    def _look_again(self, state: State, index: int) -> tuple[Finding, State]:
        """The effect, what it is worth, and what could stand in its place; and the state with what should."""
        without = self.without(state, index)
        term = state.terms[index]
        gain = self.gain(without, state)
        lines = sum(other.name == term.name for other in state.terms)
        if term.effect.always_true or lines > 1:  # one line of a spectrum has no other explanation than the others
            return Finding(term, gain, (), without.residuals, state.residuals), state
        options = self.finder.instead_of(term.name, without)
        others = [one for one in options if possible(one, without)]
        alike = self._alike(without.solution.loss, [state, *others])
        best = self._simplest(without, [state, *others])
        if best is not state and not self._confirmed(without, best):
            best = state
        names = [
            one.terms[-1].name
            for one in alike
            if one is not state and not self._settles(one, state) and not self.finder.no_more(term.name, state, one)
        ]
        names = names if any(one is state for one in alike) else []  # what explains far more is no other name for it
        return Finding(term, gain, tuple(names[:3]), without.residuals, state.residuals), best
