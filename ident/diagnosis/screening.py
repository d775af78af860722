"""Screen all effects of the library for what they could explain of a residual, by linear algebra alone.

The columns of each candidate, at every initial shape, are projected onto the orthogonal complement of the model's
regressor, including the effects already in it. The projected columns then give the reduction of the loss, as in
orthogonal forward selection. Correlation with the residual alone is not used.
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
"""A column is not excited if its part outside of the model's column space is below this share of its size."""
_MAX_SUBSET_JOINTS = 4
"""Up to this number of joints, all subsets are tried."""
_MAX_LINES = 4
"""Number of candidates kept for an effect that may occur several times."""
_LINEAR_RANGE = 0.7
"""The coefficient of a nonlinear effect may differ from the linearization point by this much (natural logarithm)
before that point becomes a second initial guess."""
_TINY = 1e-12
_MIN_JOINT_SHARE = 0.03
"""A joint must add this share of the reduction to be included."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect on some joints, with initial guesses of its parameters."""

    term: Term
    initial_guesses: tuple[Floats, ...]
    """(own + shapes,) entries of the parameter vector: by linear extrapolation, and the linearization point if that
    differs."""
    loss: float
    """Expected weighted sum of squares with the candidate."""
    parameter_count: int
    """Number of its local parameters, including optimized shapes."""
    coefficients: Floats
    """(instances * c,) of its columns, by linear extrapolation."""
    scale: Floats
    """(instances, c) local parameter per unit of column coefficient at the linearization point."""
    shapes: Floats
    """(s,) shape parameters of its columns."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Weighted columns (r, instances * c) of an effect at one initial guess."""

    columns: Floats
    scale: Floats
    """(instances, c) local parameter per unit of column coefficient."""
    shapes: Floats
    one_signed: Floats
    """(c,) 1 where only a positive coefficient is possible, else 0."""


class Screener:
    """Screens candidates against one model."""

    def __init__(self, material: SplitData, solution: Solution) -> None:
        self._split, self._solution = material, solution
        regressor, self._residual = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        self._basis = np.linalg.qr(regressor[:, size > 0] / size[size > 0])[0]
        self.loss = solution.loss
        self._predictors = [material.predictors[i] for i in material.train_indices]

    def screen(self, library: Mapping[str, Effect]) -> tuple[list[Candidate], dict[str, Exclusion]]:
        """The best candidate of every effect, the most promising first, and the reason why others are excluded.

        Effects that may occur several times have several candidates.
        """
        found: list[Candidate] = []
        unseen: dict[str, Exclusion] = {}
        for name, effect in library.items():
            judged = [self._evaluate(name, effect, block) for block in self._blocks(name, effect)]
            candidates = [one for one in judged if isinstance(one, Candidate)]
            if candidates:
                candidates.sort(key=lambda one: one.loss)
                found += candidates[:_MAX_LINES] if effect.repeated else [_merge_guesses(candidates[: effect.valleys])]
            else:
                unseen[name] = "sign" if "sign" in judged else "collinear"
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
            places += [(_by_instance(one, effect.parameters, owners), _vector(one, effect.shapes)) for one in whole]
            for at, values in places:
                yield self._signal(name, effect, at, values)

    def _joints(self, effect: Effect) -> tuple[int, ...]:
        return tuple(range(self._solution.structure.rig.dof))

    def _suggested(self, effect: Effect) -> list[Suggestion]:
        """Initial guesses that the effect suggests from the residual of each recording."""
        if effect.suggest is None:
            return []
        found: list[Suggestion] = []
        x, composition = self._solution.x, self._solution.structure
        pairs = zip(self._predictors, self._solution.weights, self._solution.residuals, strict=True)
        for evaluator, weight, residual in pairs:
            view = evaluator.effect_inputs(evaluator.corrected_motion(composition, x), composition.load(x))
            left = np.where(weight > 0, residual, np.nan)
            found += effect.suggest(view.every(evaluator.prepared.preprocessed.decimation), left)
        return found

    def _additive(self, term: Term, shapes: Floats) -> Floats:
        x, composition = self._solution.x, self._solution.structure
        rigid = composition.load(x)
        parts = []
        for evaluator, weight in zip(self._predictors, self._solution.weights, strict=True):
            columns = evaluator.columns(term, shapes, evaluator.corrected_motion(composition, x), rigid)
            parts.append(self._weighted(evaluator.prepared.condition(columns), weight))
        return np.concatenate(parts)

    def _signal(self, name: str, effect: Signal, starts: Floats, shapes: Floats) -> _Block:
        """Torque differences by the effect at `guesses` (instances, c), one column per instance and parameter."""
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
        composition = solution.structure.plus(term)
        x = np.concatenate([solution.x, own, shapes])
        rigid = solution.structure.load(solution.x)
        parts = []
        for evaluator, weight, residual in zip(self._predictors, solution.weights, solution.residuals, strict=True):
            before = evaluator.prepared.dataset.torque - residual
            parts.append(self._weighted((evaluator.torque(composition, x, rigid) - before)[:, :, None], weight)[:, 0])
        return np.concatenate(parts)

    def _weighted(self, columns: Floats, weight: Floats) -> Floats:
        rows: Floats = np.nan_to_num(columns[weight > 0]) * weight[weight > 0][:, None]
        return rows

    def _evaluate(self, name: str, effect: Effect, block: _Block) -> Candidate | Exclusion:
        """The best joints for `block`, or the reason why there are none."""
        c = block.scale.shape[1]
        size = np.sqrt((block.columns**2).sum(axis=0))
        rest = block.columns - self._basis @ (self._basis.T @ block.columns)
        rest -= self._basis @ (self._basis.T @ rest)
        seen = np.sqrt((rest**2).sum(axis=0)) > MIN_EXCITATION * size
        gram, right = rest.T @ rest, rest.T @ self._residual
        owners = [owner for owner in range(len(size) // c) if seen[owner * c : owner * c + c].any() and size.any()]
        subsets = {subset: self._reduction(gram, right, subset, block, c) for subset in _subsets(owners)}
        best = _parsimonious({subset: gain for subset, (gain, _) in subsets.items()})
        if best is None:
            return "sign" if owners else "collinear"
        gain, coefficients = subsets[best]
        term = Term(name, effect, self._joints(effect) if effect.whole_robot else best)
        scale = block.scale[list(best)]
        starts = [np.concatenate([(coefficients.reshape(-1, c) * scale).ravel(), block.shapes])]
        if isinstance(effect, Signal) and not (np.abs(np.log(np.abs(coefficients) + _TINY)) < _LINEAR_RANGE).all():
            looked = (np.sign(coefficients).reshape(-1, c) * scale).ravel()
            starts.append(np.concatenate([looked, block.shapes]))
        own = len(best) * c + sum(shape.searched for shape in effect.shapes)
        return Candidate(term, tuple(starts), max(self.loss - gain, 0.0), own, coefficients, scale, block.shapes)

    def _reduction(
        self, gram: Floats, right: Floats, subset: tuple[int, ...], block: _Block, c: int
    ) -> tuple[float, Floats]:
        """Reduction of the loss by the instances in `subset`, and their coefficients; -inf if a coefficient has the
        wrong sign.
        """
        which = np.concatenate([np.arange(owner * c, owner * c + c) for owner in subset])
        own = gram[np.ix_(which, which)]
        size = np.sqrt(np.diag(own))
        size[size == 0] = 1.0
        coefficients = np.linalg.lstsq(own / np.outer(size, size), right[which] / size, rcond=1e-9)[0] / size
        if (coefficients * np.tile(block.one_signed, len(subset)) < 0).any():
            return -np.inf, coefficients
        return float(coefficients @ right[which]), coefficients


def _subsets(owners: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All subsets; with many joints, each alone and all together."""
    if len(owners) <= _MAX_SUBSET_JOINTS:
        for size in range(1, len(owners) + 1):
            yield from combinations(owners, size)
    else:
        yield from ((owner,) for owner in owners)
        yield tuple(owners)


def _parsimonious(gains: Mapping[tuple[int, ...], float]) -> tuple[int, ...] | None:
    """The smallest subset to which no further joint would add much."""
    possible = {subset: gain for subset, gain in gains.items() if gain > 0}
    if not possible:
        return None
    most = max(possible.values())
    return min(possible, key=lambda subset: most - possible[subset] + _MIN_JOINT_SHARE * most * len(subset))


def _merge_guesses(candidates: Sequence[Candidate]) -> Candidate:
    """The first of the `candidates`, with the initial guesses of all that act on the same joints."""
    best = candidates[0]
    starts = [start for one in candidates if one.term == best.term for start in one.initial_guesses]
    return replace(best, starts=tuple(starts))


def _vector(values: Suggestion, quantities: Sequence[Quantity]) -> Floats:
    """The `values` of the `quantities`, in their order."""
    return np.array([values[one.name] for one in quantities], float)


def _by_instance(values: Suggestion, quantities: Sequence[Quantity], owners: int) -> Floats:
    """(instances, c) `values` of the `quantities`, in their order."""
    return np.stack([np.broadcast_to(np.asarray(values[one.name], float), owners) for one in quantities], axis=1)


def _padded(starts: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """Sequences padded to the length of the longest by repeating the last value."""
    longest = max(len(one) for one in starts)
    return [(*one, *[one[-1]] * (longest - len(one))) for one in starts]
