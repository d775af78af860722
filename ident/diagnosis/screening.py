"""Which effects could explain what a model leaves: a first look at all of them, by linear algebra alone.

Each candidate's columns, at every shape that its search would begin with, lose what the model so far (all of its
parameters, also those of effects already in it) could imitate of them; what is left explains so much of the residual
as an orthogonal forward selection says. No candidate is judged by its likeness to the residual itself.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Exclusion
from ident.dynamics.effects.base import Additive, Effect, Quantity, Signal, Suggestion
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

MIN_EXCITATION = 1e-3
"""Below this share of its size that no parameter of the model imitates, a column counts as not excited."""
_SUBSETS_UP_TO = 4
"""Joints up to which all their subsets are tried."""
_LINES = 4
"""Places of an effect that may be there several times which are kept."""
_STRAIGHT = 0.7
"""A distortion that is to be larger or smaller than where it was looked at by more than this (natural logarithm) may
be bent on the way."""
_TINY = 1e-12
_SHARE = 0.03
"""What a joint must add to the gain of an effect to be among its joints."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect on some joints, and where the search for its parameters begins."""

    term: Term
    initial_guesses: tuple[Floats, ...]
    """(own + shapes,) its entries of the parameter vector: as far as a straight line tells, and where it was looked
    at, if that is elsewhere."""
    loss: float
    """Weighted sum of squares that it is expected to leave."""
    parameter_count: int
    """How many own parameters it has, in all, with its searched shapes."""
    coefficients: Floats
    """(owners * c,) of its columns, as far as a straight line tells."""
    scale: Floats
    """(owners, c) where it was looked at: own parameter per unit of column coefficient."""
    shapes: Floats
    """(s,) shape parameters of its columns."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Weighted columns (r, owners * c) of an effect at one start, and the start of each owner's parameters."""

    columns: Floats
    scale: Floats
    """(owners, c) parameter per unit of column coefficient."""
    shapes: Floats
    one_signed: Floats
    """(c,) +1 where only a positive coefficient is meant, else 0."""


class Screener:
    """A model so far, ready to look at candidates."""

    def __init__(self, material: SplitData, solution: Solution) -> None:
        self._material, self._solution = material, solution
        regressor, self._residual = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        self._basis = np.linalg.qr(regressor[:, size > 0] / size[size > 0])[0]
        self.loss = solution.loss
        self._evaluators = [material.predictors[i] for i in material.train_indices]

    def screen(self, library: Mapping[str, Effect]) -> tuple[list[Candidate], dict[str, Exclusion]]:
        """The best start of every effect, the most promising first, and why the others have none.

        Of what may be there several times, several.
        """
        found: list[Candidate] = []
        unseen: dict[str, Exclusion] = {}
        for name, effect in library.items():
            judged = [self._judged(name, effect, block) for block in self._blocks(name, effect)]
            candidates = [one for one in judged if isinstance(one, Candidate)]
            if candidates:
                candidates.sort(key=lambda one: one.loss)
                found += candidates[:_LINES] if effect.repeated else [_together(candidates[: effect.valleys])]
            else:
                unseen[name] = "sign" if "sign" in judged else "imitated"
        return sorted(found, key=lambda one: one.loss), unseen

    def _blocks(self, name: str, effect: Effect) -> Iterator[_Block]:
        suggested = self._suggested(effect)
        own = effect.parameters[0].name if isinstance(effect, Signal) else ""
        whole = [one for one in suggested if own in one]
        shapes = [np.array(values, float) for values in product(*(shape.starts for shape in effect.shapes))]
        shapes += [_vector(one, effect.shapes) for one in suggested if own not in one]
        if isinstance(effect, Additive):
            one_signed = np.array([float(q.lower >= 0) for q in effect.coefficients])
            for values in shapes:
                columns = self._additive(Term(name, effect, self._joints(effect)), values)
                owners = columns.shape[1] // len(effect.coefficients)
                yield _Block(columns, np.ones((owners, len(effect.coefficients))), values, one_signed)
        elif isinstance(effect, Signal):
            owners = 1 if effect.whole_robot else len(self._joints(effect))
            starts = [np.array(one) for one in zip(*_padded([q.starts for q in effect.parameters]), strict=True)]
            places = [(np.tile(one, (owners, 1)), values) for one, values in product(starts, shapes)]
            places += [(_by_owner(one, effect.parameters, owners), _vector(one, effect.shapes)) for one in whole]
            for at, values in places:
                yield self._signal(name, effect, at, values)

    def _joints(self, effect: Effect) -> tuple[int, ...]:
        return tuple(range(self._solution.composition.rig.dof))

    def _suggested(self, effect: Effect) -> list[Suggestion]:
        """What the effect suggests from the residual of each recording."""
        if effect.suggest is None:
            return []
        found: list[Suggestion] = []
        x, composition = self._solution.x, self._solution.composition
        pairs = zip(self._evaluators, self._solution.weights, self._solution.residuals, strict=True)
        for evaluator, weight, residual in pairs:
            view = evaluator.view(evaluator.path(composition, x), composition.load(x))
            left = np.where(weight > 0, residual, np.nan)
            found += effect.suggest(view.every(evaluator.course.prepared.step), left)
        return found

    def _additive(self, term: Term, shapes: Floats) -> Floats:
        x, composition = self._solution.x, self._solution.composition
        rigid = composition.load(x)
        parts = []
        for evaluator, weight in zip(self._evaluators, self._solution.weights, strict=True):
            columns = evaluator.columns(term, shapes, evaluator.path(composition, x), rigid)
            parts.append(self._weighted(evaluator.course.condition(columns), weight))
        return np.concatenate(parts)

    def _signal(self, name: str, effect: Signal, starts: Floats, shapes: Floats) -> _Block:
        """Differences that the effect makes at `starts` (owners, c), owner by owner and parameter by parameter."""
        owners = [self._joints(effect)] if effect.whole_robot else [(joint,) for joint in self._joints(effect)]
        columns = [
            self._difference(Term(name, effect, owner), np.where(np.arange(len(own)) == i, own, 0.0), shapes)
            for owner, own in zip(owners, starts, strict=True)
            for i in range(len(own))
        ]
        one_signed = np.array([float(q.lower >= 0) for q in effect.parameters])
        return _Block(np.stack(columns, axis=1), starts, shapes, one_signed)

    def _difference(self, term: Term, own: Floats, shapes: Floats) -> Floats:
        solution = self._solution
        composition = solution.composition.plus(term)
        x = np.concatenate([solution.x, own, shapes])
        rigid = solution.composition.load(solution.x)
        parts = []
        for evaluator, weight, residual in zip(self._evaluators, solution.weights, solution.residuals, strict=True):
            before = evaluator.course.dataset.torque - residual
            parts.append(self._weighted((evaluator.torque(composition, x, rigid) - before)[:, :, None], weight)[:, 0])
        return np.concatenate(parts)

    def _weighted(self, columns: Floats, weight: Floats) -> Floats:
        rows: Floats = np.nan_to_num(columns[weight > 0]) * weight[weight > 0][:, None]
        return rows

    def _judged(self, name: str, effect: Effect, block: _Block) -> Candidate | Exclusion:
        """The best joints for `block`, or why there are none."""
        c = block.scale.shape[1]
        size = np.sqrt((block.columns**2).sum(axis=0))
        rest = block.columns - self._basis @ (self._basis.T @ block.columns)
        rest -= self._basis @ (self._basis.T @ rest)
        seen = np.sqrt((rest**2).sum(axis=0)) > MIN_EXCITATION * size
        gram, right = rest.T @ rest, rest.T @ self._residual
        owners = [owner for owner in range(len(size) // c) if seen[owner * c : owner * c + c].any() and size.any()]
        subsets = {subset: self._gain(gram, right, subset, block, c) for subset in _subsets(owners)}
        best = _parsimonious({subset: gain for subset, (gain, _) in subsets.items()})
        if best is None:
            return "sign" if owners else "imitated"
        gain, coefficients = subsets[best]
        term = Term(name, effect, self._joints(effect) if effect.whole_robot else best)
        scale = block.scale[list(best)]
        starts = [np.concatenate([(coefficients.reshape(-1, c) * scale).ravel(), block.shapes])]
        if isinstance(effect, Signal) and not (np.abs(np.log(np.abs(coefficients) + _TINY)) < _STRAIGHT).all():
            looked = (np.sign(coefficients).reshape(-1, c) * scale).ravel()
            starts.append(np.concatenate([looked, block.shapes]))
        own = len(best) * c + sum(shape.searched for shape in effect.shapes)
        return Candidate(term, tuple(starts), max(self.loss - gain, 0.0), own, coefficients, scale, block.shapes)

    def _gain(
        self, gram: Floats, right: Floats, subset: tuple[int, ...], block: _Block, c: int
    ) -> tuple[float, Floats]:
        """Fall of the loss by the owners in `subset`, and their coefficients; none if a sign is against it."""
        which = np.concatenate([np.arange(owner * c, owner * c + c) for owner in subset])
        own = gram[np.ix_(which, which)]
        size = np.sqrt(np.diag(own))
        size[size == 0] = 1.0
        coefficients = np.linalg.lstsq(own / np.outer(size, size), right[which] / size, rcond=1e-9)[0] / size
        if (coefficients * np.tile(block.one_signed, len(subset)) < 0).any():
            return -np.inf, coefficients
        return float(coefficients @ right[which]), coefficients


def _subsets(owners: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All of them, or with many joints each alone and all together."""
    if len(owners) <= _SUBSETS_UP_TO:
        for size in range(1, len(owners) + 1):
            yield from combinations(owners, size)
    else:
        yield from ((owner,) for owner in owners)
        yield tuple(owners)


def _parsimonious(gains: Mapping[tuple[int, ...], float]) -> tuple[int, ...] | None:
    """The fewest joints of which none more would add much to the gain."""
    possible = {subset: gain for subset, gain in gains.items() if gain > 0}
    if not possible:
        return None
    most = max(possible.values())
    return min(possible, key=lambda subset: most - possible[subset] + _SHARE * most * len(subset))


def _together(candidates: Sequence[Candidate]) -> Candidate:
    """The first of the `candidates`, with the starts of those that are on the same joints."""
    best = candidates[0]
    starts = [start for one in candidates if one.term == best.term for start in one.initial_guesses]
    return replace(best, starts=tuple(starts))


def _vector(values: Suggestion, quantities: Sequence[Quantity]) -> Floats:
    """The `values` of the `quantities`, in their order."""
    return np.array([values[one.name] for one in quantities], float)


def _by_owner(values: Suggestion, quantities: Sequence[Quantity], owners: int) -> Floats:
    """(owners, c) the `values` of the `quantities`, in their order."""
    return np.stack([np.broadcast_to(np.asarray(values[one.name], float), owners) for one in quantities], axis=1)


def _padded(starts: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """All as long as the longest, the last one repeated."""
    longest = max(len(one) for one in starts)
    return [(*one, *[one[-1]] * (longest - len(one))) for one in starts]
