"""Screen all effects of the library for what they could explain of a residual, by linear algebra alone.

The columns of each candidate, at every initial shape, are projected onto the orthogonal complement of the model's
regressor, including the effects already in it. The projected columns then give the reduction of the loss, as in
orthogonal forward selection. Correlation with the residual alone is not used.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

import numpy as np

from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Exclusion
from ident.dynamics.effects.base import Additive, Effect, Quantity, Signal, Suggestion
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from ident.threads import in_threads
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
    """(local + shapes,) entries of the parameter vector: by linear extrapolation, and the linearization point if it
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
    """(c,) 1 where only a positive coefficient is possible, -1 where only a negative one is, else 0."""


class Screener:
    """Screens candidates against one model."""

    def __init__(self, split: SplitData, solution: Solution) -> None:
        self._split, self._solution = split, solution
        regressor, self._residual = solution.rows()
        size = np.sqrt((regressor**2).sum(axis=0))
        self._basis = np.linalg.qr(regressor[:, size > 0] / size[size > 0])[0]
        self._regressor, self._size = regressor, np.where(size > 0, size, 1.0)
        self.loss = solution.loss
        self._predictors = [split.predictors[i] for i in split.train_indices]

    def screen(self, library: Mapping[str, Effect]) -> tuple[list[Candidate], dict[str, Exclusion]]:
        """The best candidate of every effect, the most promising first, and the reason why others are excluded.

        Effects that may occur several times have several candidates.
        """
        best: list[Candidate] = []
        excluded: dict[str, Exclusion] = {}
        all_results = in_threads(self._results, library.keys(), library.values())
        for (name, effect), results in zip(library.items(), all_results, strict=True):
            candidates = [candidate for candidate in results if isinstance(candidate, Candidate)]
            if candidates:
                candidates.sort(key=lambda candidate: candidate.loss)
                best += (
                    candidates[:_MAX_LINES] if effect.repeated else [_merge_guesses(candidates[: effect.multistart])]
                )
            else:
                excluded[name] = "sign" if "sign" in results else "collinear"
        return sorted(best, key=lambda candidate: candidate.loss), excluded

    def _results(self, name: str, effect: Effect) -> list[Candidate | Exclusion]:
        """A candidate for each initial guess of the shapes of `effect`, or the reason why there is none."""
        return [self._evaluate(name, effect, block) for block in self._blocks(name, effect)]

    def _blocks(self, name: str, effect: Effect) -> Iterator[_Block]:
        term = Term.on_all_joints(name, effect, self._solution.structure.rig)
        one_signed = np.array([float(q.lower >= 0) - float(q.upper <= 0) for q in term.local_parameters])
        for guess, shapes in self._initial_guesses(term):
            yield _Block(self._columns(term, guess, shapes), guess, shapes, one_signed)

    def _initial_guesses(self, term: Term) -> list[tuple[Floats, Floats]]:
        """Local parameters (instances, c), 1 for coefficients, and shapes (s,) at which columns are made."""
        effect, suggestions = term.effect, self._suggested(term.effect)
        first_parameter = effect.parameters[0].name if isinstance(effect, Signal) else ""
        complete = [suggestion for suggestion in suggestions if first_parameter in suggestion]
        shapes = [np.array(values, float) for values in product(*(shape.initial_guesses for shape in effect.shapes))]
        shapes += [
            _vector(suggestion, effect.shapes) for suggestion in suggestions if first_parameter not in suggestion
        ]
        if isinstance(effect, Additive):
            starts = [np.ones(len(effect.coefficients))]
        else:
            guesses = _padded([quantity.initial_guesses for quantity in term.local_parameters])
            starts = [np.array(start) for start in zip(*guesses, strict=True)]
        pairs = [
            *((np.tile(start, (term.instances, 1)), values) for start, values in product(starts, shapes)),
            *(
                (_by_instance(suggestion, term.local_parameters, term.instances), _vector(suggestion, effect.shapes))
                for suggestion in complete
            ),
        ]
        # Several recordings may suggest the same.
        return list({(start.tobytes(), values.tobytes()): (start, values) for start, values in pairs}.values())

    def _columns(self, term: Term, guess: Floats, shapes: Floats) -> Floats:
        """(r, instances * c) weighted rows of `effect_columns`."""
        solution, rows = self._solution, []
        for predictor, weight, residual in zip(self._predictors, solution.weights, solution.residuals, strict=True):
            computed = predictor.prepared.torque - residual
            columns = effect_columns(predictor, solution, term, guess, shapes, computed)
            rows.append(np.nan_to_num(columns[weight > 0]) * weight[weight > 0][:, None])
        return np.concatenate(rows)

    def _suggested(self, effect: Effect) -> list[Suggestion]:
        """Initial guesses that the effect suggests from the residual of each recording."""
        if effect.suggest is None:
            return []
        suggestions: list[Suggestion] = []
        x, structure = self._solution.x, self._solution.structure
        pairs = zip(self._predictors, self._solution.weights, self._solution.residuals, strict=True)
        for predictor, weight, residual in pairs:
            inputs = predictor.effect_inputs(structure, x)
            masked = np.where(weight > 0, residual, np.nan)
            suggestions += effect.suggest(inputs.decimated(predictor.prepared.preprocessed.decimation), masked)
        return suggestions

    def _evaluate(self, name: str, effect: Effect, block: _Block) -> Candidate | Exclusion:
        """The best joints for `block`, or the reason why there are none."""
        c = block.scale.shape[1]
        size = np.sqrt((block.columns**2).sum(axis=0))
        orthogonal = block.columns - self._basis @ (self._basis.T @ block.columns)
        orthogonal -= self._basis @ (self._basis.T @ orthogonal)
        excited = np.sqrt((orthogonal**2).sum(axis=0)) > MIN_EXCITATION * size
        everywhere = Term.on_all_joints(name, effect, self._solution.structure.rig)
        products = _Products(
            orthogonal.T @ orthogonal, orthogonal.T @ self._residual, self._replaced(everywhere, block)
        )
        instances = [
            instance
            for instance in range(len(size) // c)
            if excited[instance * c : instance * c + c].any() and size.any()
        ]
        subsets = {subset: _reduction(products, subset, block, c) for subset in _subsets(instances)}
        best = _parsimonious({subset: reduction for subset, (reduction, _) in subsets.items()})
        if best is None:
            return "sign" if instances else "collinear"
        reduction, coefficients = subsets[best]
        term = (
            everywhere
            if effect.whole_robot
            else replace(everywhere, joints=tuple(everywhere.joints[i] for i in best))
        )
        scale = block.scale[list(best)]
        guesses = [np.concatenate([(coefficients.reshape(-1, c) * scale).ravel(), block.shapes])]
        if isinstance(effect, Signal) and not (np.abs(np.log(np.abs(coefficients) + _TINY)) < _LINEAR_RANGE).all():
            linearized_at = (np.sign(coefficients).reshape(-1, c) * scale).ravel()
            guesses.append(np.concatenate([linearized_at, block.shapes]))
        parameter_count = len(best) * c + sum(shape.searched for shape in effect.shapes)
        return Candidate(
            term, tuple(guesses), max(self.loss - reduction, 0.0), parameter_count, coefficients, scale, block.shapes
        )

    def _replaced(self, term: Term, block: _Block) -> "_Replaced | None":
        """What it costs to remove the friction of the mechanism that the effect replaces, on each of its joints."""
        if term.effect.replaces is None:
            return None
        names = [entry.name for entry in self._solution.structure.parameters]
        entries = [names.index(f"{term.effect.replaces}{joint + 1}") for joint in term.joints]
        # Of a matrix A, column j of pinv(A)' is orthogonal to all columns of A but the column j.
        dual = self._dual[:, entries]
        return _Replaced(dual.T @ dual, dual.T @ block.columns, self._solution.x[entries] + dual.T @ self._residual)

    @cached_property
    def _dual(self) -> Floats:
        """(r, K) transposed pseudoinverse of the model's regressor."""
        dual: Floats = np.linalg.pinv(self._regressor / self._size).T / self._size
        return dual


@dataclass(frozen=True, eq=False)
class _Replaced:
    """The direction in which each of j columns of the model differs from all others: its dual vector."""

    gram: Floats
    """(j, j) products of the dual vectors."""
    columns: Floats
    """(j, instances * c) their products with the columns of the effect."""
    target: Floats
    """(j,) their products with the residual without these columns."""


@dataclass(frozen=True, eq=False)
class _Products:
    """Products of the columns of an effect, made orthogonal to those of the model."""

    gram: Floats
    """(instances * c, instances * c)"""
    correlation: Floats
    """(instances * c,) with the residual."""
    replaced: _Replaced | None

    def of_subset(self, subset: tuple[int, ...]) -> tuple[Floats, Floats, float]:
        """Both products and the increase of the loss, without the columns that are replaced on the `subset`."""
        if self.replaced is None:
            return self.gram, self.correlation, 0.0
        joints = list(subset)
        columns, target = self.replaced.columns[joints], self.replaced.target[joints]
        inverse = np.linalg.pinv(self.replaced.gram[np.ix_(joints, joints)])
        return (
            self.gram + columns.T @ inverse @ columns,
            self.correlation + columns.T @ inverse @ target,
            float(target @ inverse @ target),
        )


def _reduction(products: _Products, subset: tuple[int, ...], block: _Block, c: int) -> tuple[float, Floats]:
    """Reduction of the loss by the instances in `subset`, -inf if a sign is wrong; and their coefficients."""
    gram, correlation, increase = products.of_subset(subset)
    entries = np.concatenate([np.arange(instance * c, instance * c + c) for instance in subset])
    normal_matrix = gram[np.ix_(entries, entries)]
    size = np.sqrt(np.diag(normal_matrix))
    size[size == 0] = 1.0
    coefficients = (
        np.linalg.lstsq(normal_matrix / np.outer(size, size), correlation[entries] / size, rcond=1e-9)[0] / size
    )
    if (coefficients * np.tile(block.one_signed, len(subset)) < 0).any():
        return -np.inf, coefficients
    return float(coefficients @ correlation[entries]) - increase, coefficients


def effect_columns(
    predictor: TorquePredictor, solution: Solution, term: Term, local: Floats, shapes: Floats, computed: Floats
) -> Floats:
    """(m, dof, instances * c) columns of a `term` beside the model of `solution`, which stays as it is.

    They are the torque per unit of each coefficient; or the change of the `computed` torque (m, dof) by each
    parameter of a signal effect, of the size `local` (instances, c).
    """
    structure = solution.structure.with_term(term)
    load = solution.structure.load_parameters(solution.x)

    def at(values: Floats) -> Floats:
        return np.concatenate([solution.x, values, shapes])

    if isinstance(term.effect, Additive):
        last = len(structure.terms) - 1
        return predictor.conditioned_columns(structure, last, at(np.zeros(local.size)), load)
    changes = [predictor.torque(structure, at(values), load) - computed for values in np.diag(local.ravel())]
    return np.stack(changes, axis=2)


def _subsets(instances: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All subsets; with many joints, each alone and all together."""
    if len(instances) <= _MAX_SUBSET_JOINTS:
        for size in range(1, len(instances) + 1):
            yield from combinations(instances, size)
    else:
        yield from ((instance,) for instance in instances)
        yield tuple(instances)


def _parsimonious(reductions: Mapping[tuple[int, ...], float]) -> tuple[int, ...] | None:
    """The smallest subset to which no further joint would add much."""
    possible = {subset: reduction for subset, reduction in reductions.items() if reduction > 0}
    if not possible:
        return None
    largest = max(possible.values())
    return min(possible, key=lambda subset: largest - possible[subset] + _MIN_JOINT_SHARE * largest * len(subset))


def _merge_guesses(candidates: Sequence[Candidate]) -> Candidate:
    """The first of the `candidates`, with the initial guesses of all that act on the same joints."""
    best = candidates[0]
    guesses = [
        guess for candidate in candidates if candidate.term == best.term for guess in candidate.initial_guesses
    ]
    return replace(best, initial_guesses=tuple(guesses))


def _vector(values: Suggestion, quantities: Sequence[Quantity]) -> Floats:
    """The `values` of the `quantities`, in their order."""
    return np.array([values[quantity.name] for quantity in quantities], float)


def _by_instance(values: Suggestion, quantities: Sequence[Quantity], instances: int) -> Floats:
    """(instances, c) `values` of the `quantities`, in their order."""
    return np.stack(
        [np.broadcast_to(np.asarray(values[quantity.name], float), instances) for quantity in quantities], axis=1
    )


def _padded(sequences: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """Sequences padded to the length of the longest by repeating the last value."""
    longest = max(len(sequence) for sequence in sequences)
    return [(*sequence, *[sequence[-1]] * (longest - len(sequence))) for sequence in sequences]
