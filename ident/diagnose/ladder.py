"""The ladder: add the effect that explains most, refit everything, ask again, until nothing is left to explain."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ident.composition import Composition, Term
from ident.diagnose.evidence import Gain, gain
from ident.diagnose.floor import Floor, floor
from ident.diagnose.material import Material
from ident.diagnose.rungs import Finding, Ladder, Rung, State
from ident.diagnose.screen import Candidate, Screen
from ident.effects import Effect
from recordings.errors import BadInput
from recordings.recording import Floats

MOST = 16
"""Effects that are added at most."""
ROUNDS = 3
"""Times that effects already found are put to the question again."""
REFINED = 6
"""Candidates of each round whose parameters are searched; the others promise too little."""
PROMISING = 0.4
"""Nor is one that at first sight would gain less than this share of what the best has gained: a search for its
parameters seldom doubles that."""
ALIKE = 0.04
"""Candidates whose gains differ by less than this share of it explain the same."""
CLEAR = 15.0
"""Fall of the loss per parameter, over what noise alone makes of it, from which on it counts."""
CERTAIN = 3.5
"""Student's t of the held-out fall from which on it counts; all the candidates were tried."""
SURE = 0.1
"""Lower end of the interval of the held-out gain from which on it counts, too."""
SETTLED = 0.5
"""Share of what another explanation leaves above the floor that, once taken away, speaks against it."""
WORTH = 0.05
"""Share of what is above the floor, without an effect, that makes it stay in the model."""
MATERIAL = 0.002
"""What changes the residual by less than this share of the torque is left alone."""


class Climber:
    """Climbs the ladder on some material with a library of effects."""

    def __init__(self, material: Material, library: Mapping[str, Effect], progress: Callable[[str], None]) -> None:
        self._material, self._library, self._progress = material, library, progress
        self._first: dict[str, float] = {}  # what each candidate would have gained at the beginning

    def state(self, composition: Composition, x: Floats) -> State:
        """`composition` fitted from `x` (K,)."""
        solution = self._material.solve(composition, x)
        return State(solution, self._material.residuals(solution))

    def climb(self, composition: Composition, x: Floats) -> Ladder:
        """From `composition` upwards, fitted from `x` (K,)."""
        state, rungs = self.begin(composition, x)
        for _ in range(ROUNDS):
            state, unseen, last = self._up(state, rungs)
            looked = [self._look_again(state, index) for index in range(len(state.terms))]
            better = next((found for _, found in looked if found is not state), None)
            if better is None:
                break
            state = self._settled(better)
            rungs.append(Rung(better.terms[-1].name, state, self.gain(rungs[-1].state, state)))
        found = tuple(finding for finding, _ in looked)
        return Ladder(tuple(rungs), found, tuple(unseen), self._first, last, self.floor(state), self._computed(state))

    def by_hand(self, composition: Composition, x: Floats, names: Sequence[str]) -> Ladder:
        """From `composition` upwards, fitted from `x` (K,), by the effects `names` in this order, and no others.

        Raises:
            BadInput: the motion does not show one of them.
        """
        state, rungs = self.begin(composition, x)
        for name in names:
            found = {one.term.name: one for one in reversed(self.look(state)[0])}
            if name not in found:
                raise BadInput(f"effect: one of {', '.join(sorted(found))} expected, '{name}' found; leave it out")
            state = self.added(state, found[name])
            rungs.append(Rung(name, state, self.gain(rungs[-1].state, state)))
        _, unseen, gains = self.look(state)
        findings = tuple(self._look_again(state, index)[0] for index in range(len(state.terms)))
        return Ladder(tuple(rungs), findings, tuple(unseen), gains, gains, self.floor(state), self._computed(state))

    def begin(self, composition: Composition, x: Floats) -> tuple[State, list[Rung]]:
        """The state with all that is true anyway, fitted from `x` (K,), and the first rungs."""
        base = self.state(composition, x)
        rungs = [Rung(None, base, None)]
        return self._with_truths(base, rungs), rungs

    def _up(self, state: State, rungs: list[Rung]) -> tuple[State, list[str], dict[str, float]]:
        """The state when nothing more is worth adding; what the motion does not show; what the rest would gain."""
        while True:
            options, unseen, gains = self._options(state)
            self._first = self._first or gains
            chosen = self._first_confirmed(state, options) if len(state.terms) < MOST else None
            if chosen is None:
                return state, unseen, gains
            state = self._settled(chosen)
            rungs.append(Rung(chosen.terms[-1].name, state, self.gain(rungs[-1].state, state)))
            self._progress(f"{rungs[-1].added} added; what else?")

    def floor(self, state: State) -> Floor:
        """The line to reach."""
        return floor(self._material, state.solution, state.residuals)

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
            after = self.state(composition, np.concatenate([state.solution.x, added]))
            if self._confirmed(state, after):
                rungs.append(Rung(name, after, self.gain(state, after)))
            state = after
        return state

    def _options(self, state: State, leave: Sequence[str] = ()) -> tuple[list[State], list[str], dict[str, float]]:
        """States with one effect more, the best first; what does not show; what each would gain at first sight."""
        candidates, unseen, gains = self.look(state, leave)
        before = state.solution.loss
        worth = [one for one in candidates if self._clear(before, one.loss, one.own)]
        return self._refined(state, worth), unseen, gains

    def look(self, state: State, leave: Sequence[str] = ()) -> tuple[list[Candidate], list[str], dict[str, float]]:
        """What could be added, the most promising first; what does not show; what each would gain at first sight."""
        present = {term.name for term in state.terms}
        covered = {name for term in state.terms for name in term.effect.contains}
        library = {
            name: effect
            for name, effect in self._library.items()
            if (name not in present or effect.repeated) and name not in covered and name not in leave
        }
        candidates, unseen = Screen(self._material, state.solution).look(library)
        before = state.solution.loss
        gains = {one.term.name: 1 - one.loss / before for one in reversed(candidates)}
        return candidates, unseen, gains

    def _refined(self, state: State, candidates: Sequence[Candidate]) -> list[State]:
        """States with each of the `candidates`, as far as they promise anything beside the best, the best first."""
        before = state.solution.loss
        states: list[State] = []
        for one in candidates[: REFINED + 2]:
            least = min((found.solution.loss for found in states), default=before)
            if before - one.loss < PROMISING * (before - least) and not self._another(state, one):
                continue
            states.append(self.added(state, one))
        return sorted(states, key=lambda one: one.solution.loss)

    def added(self, state: State, candidate: Candidate) -> State:
        """With `candidate`, its parameters searched."""
        return self._signed(self._with(state, candidate), state)

    def _another(self, state: State, candidate: Candidate) -> bool:
        """Whether this is one more line of a spectrum of which the model has some: each is judged for itself."""
        return candidate.term.effect.repeated and any(term.name == candidate.term.name for term in state.terms)

    def _with(self, state: State, candidate: Candidate) -> State:
        composition = state.solution.composition.plus(candidate.term)
        found = [
            self._material.solve(composition, np.concatenate([state.solution.x, one])) for one in candidate.starts
        ]
        best = min(found, key=lambda one: one.loss)
        return State(best, self._material.residuals(best))

    def _signed(self, state: State, before: State) -> State:
        """Without the joints whose coefficients came out beyond what is possible, or that add next to nothing."""
        index = len(state.terms) - 1
        term = state.terms[index]
        if term.effect.whole_robot or len(term.joints) == 1:
            return state
        possible = [joint for joint, own in zip(term.joints, self._within(state, index), strict=True) if own]
        if len(possible) in (0, len(term.joints)):
            return state
        composition = before.solution.composition.plus(replace(term, joints=tuple(possible)))
        owners = [i for i, joint in enumerate(term.joints) if joint in possible]
        own = state.solution.composition.own(index, state.solution.x)[owners]
        shapes = state.solution.composition.shapes(index, state.solution.x)
        return self.state(composition, np.concatenate([before.solution.x, own.ravel(), shapes]))

    def _within(self, state: State, index: int) -> list[bool]:
        """For each owner of the term, whether its own parameters are within their physical range."""
        term = state.terms[index]
        own = state.solution.composition.own(index, state.solution.x)
        lower, upper = (np.array([getattr(q, side) for q in term.own]) for side in ("lower", "upper"))
        return [bool(((lower <= row) & (row <= upper)).all()) for row in own]

    def _first_confirmed(self, state: State, options: list[State]) -> State | None:
        """The simplest of those that explain most, if rows that no fit saw bear it out; else the next ones."""
        options = [one for one in options if all(self._within(one, len(one.terms) - 1))]
        while options:
            best = self._simplest(state, options)
            if self._confirmed(state, best):
                return best
            options = [one for one in options if one is not best]
        return None

    def _simplest(self, state: State, options: Sequence[State]) -> State:
        alike = self._alike(state.solution.loss, options)
        return min(alike, key=lambda one: (len(one.solution.x), one.solution.loss))

    def _alike(self, without: float, options: Sequence[State]) -> list[State]:
        """Those that leave no more than the best, but for chance and a small share of what there is to gain."""
        least = min(one.solution.loss for one in options)
        slack = max(ALIKE * (without - least), CLEAR * self._chance(least))
        return [one for one in options if one.solution.loss - least <= slack]

    def _chance(self, loss: float) -> float:
        """Fall of the loss that one more parameter makes by fitting noise."""
        return loss / self._material.independent_rows

    def _clear(self, before: float, after: float, parameters: int) -> bool:
        return before - after > CLEAR * parameters * self._chance(after)

    def _confirmed(self, before: State, after: State) -> bool:
        """Whether the last effect of `after` explains something, on the rows seen and on those held out."""
        parameters = len(after.solution.x) - len(before.solution.x)
        changed = [b - a for b, a in zip(before.residuals, after.residuals, strict=True)]
        size = np.sqrt([np.nanmean(np.concatenate(changed) ** 2, axis=0)])
        return (
            self._clear(before.solution.loss, after.solution.loss, parameters)
            and bool((size > MATERIAL * self._material.torque_rms).any())
            and self._holds(self.gain(before, after))
        )

    def _holds(self, gain: Gain) -> bool:
        """Whether held-out rows bear it out: everywhere a little, or much, though perhaps at few places."""
        return gain.t > CERTAIN or gain.interval[0] > SURE

    def gain(self, before: State, after: State) -> Gain:
        """What `after` explains of held-out rows beyond `before`."""
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
        """Without the term `index`, refitted."""
        composition = state.solution.composition
        keep = ~composition.entries(index)
        return self.state(composition.without(index), state.solution.x[keep])

    def _settles(self, other: State, state: State) -> bool:
        """Whether held-out rows speak for `state` against an `other` that explains nearly as much."""
        gain = self.gain(other, state)
        return gain.t > CERTAIN and gain.share > SETTLED

    def _look_again(self, state: State, index: int) -> tuple[Finding, State]:
        """The effect, what it is worth, and what could stand in its place; and the state with what should."""
        without = self.without(state, index)
        term = state.terms[index]
        gain = self.gain(without, state)
        lines = sum(other.name == term.name for other in state.terms)
        if term.effect.always_true or lines > 1:  # one line of a spectrum has no other explanation than the others
            return Finding(term, gain, (), without.residuals, state.residuals), state
        options = self._options(without, leave=(term.name,))[0]
        possible = [one for one in options if all(self._within(one, len(one.terms) - 1))]
        alike = self._alike(without.solution.loss, [state, *possible])
        best = self._simplest(without, [state, *possible])
        if best is not state and not self._confirmed(without, best):
            best = state
        names = [one.terms[-1].name for one in alike if one is not state and not self._settles(one, state)]
        return Finding(term, gain, tuple(names[:3]), without.residuals, state.residuals), best
