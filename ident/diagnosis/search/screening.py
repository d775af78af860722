"""Screen all effects of the library for what they could explain of a residual, by linear algebra alone.

The columns of each candidate, at every initial shape, are projected onto the orthogonal complement of the model's
regressor, including the effects already in it. The projected columns then give the reduction of the loss, as in
orthogonal forward selection. Correlation with the residual alone is not used.
"""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.diagnosis.search.initial_guesses import initial_guesses
from ident.diagnosis.search.joint_subsets import Products, Replaced, choose_joints
from ident.diagnosis.search.selection import Exclusion
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Additive, Effect, Signal, Suggestion
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from ident.estimation.shape_parameters import suggestions
from ident.threads import in_threads
from recordings.recording import Floats

MIN_EXCITATION = 1e-3
"""A column is not excited if its part outside of the model's column space is below this share of its size."""
_MAX_LINES = 4
"""Number of candidates kept for an effect that may occur several times."""
_LINEAR_RANGE = 0.7
"""The coefficient of a nonlinear effect may differ from the linearization point by this much (natural logarithm)
before that point becomes a second initial guess."""
_TINY = 1e-12


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

    @property
    def local_values(self) -> Floats:
        """(instances, c) local parameters, by linear extrapolation."""
        return self.coefficients.reshape(self.term.instances, -1) * self.scale


@dataclass(frozen=True, eq=False)
class _Block:
    """Weighted columns (r, instances * c) of an effect at one initial guess."""

    columns: Floats
    scale: Floats
    """(instances, c) local parameter per unit of column coefficient."""
    shapes: Floats
    one_signed: Floats
    """(c,) 1 where only a positive coefficient is possible, -1 where only a negative one is, else 0."""


ColumnsKey = tuple[str, bytes, bytes]
"""Name of an effect, and the local parameters and shapes at which its columns are computed."""


class Screener:
    """Screens candidates against one model."""

    def __init__(
        self, split: SplitData, solution: Solution, known: dict[ColumnsKey, tuple[Floats, ...]] | None = None
    ) -> None:
        """`known`: columns of signal effects beside other models of the same data, which hardly differ from them."""
        self._split, self._solution, self._known = split, solution, {} if known is None else known
        regressor, self.residual = solution.rows()
        self._set_regressor(regressor)
        self.loss = solution.loss
        self._residuals = solution.residuals
        self._predictors = [split.predictors[i] for i in split.train_indices]
        self._known_columns: dict[tuple[str, bytes, bytes], Floats] | None = None
        """Columns are kept only if several residuals are screened: those of a long recording take much memory."""

    def _set_regressor(self, regressor: Floats) -> None:
        """Evaluate candidates beside the columns of this `regressor` (r, K)."""
        size = np.sqrt((regressor**2).sum(axis=0))
        self._used = size > 0
        self._regressor, self._size = regressor, np.where(self._used, size, 1.0)
        self._basis, self._triangle = np.linalg.qr(regressor[:, self._used] / size[self._used])

    def with_residuals(self, residuals: Sequence[Floats]) -> "Screener":
        """Screener of the same model for other `residuals` (m, dof) of each training recording [N m].

        The torque of the model stays what it is, so that columns are computed once for all of them.
        """
        if self._known_columns is None:
            self._known_columns = {}
        other = copy(self)
        weights = self._solution.weights
        other._residuals = tuple(residuals)
        other.residual = np.concatenate(
            [(weight * residual)[weight > 0] for weight, residual in zip(weights, residuals, strict=True)]
        )
        other.loss = float(other.residual @ other.residual)
        return other

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
        signs = one_signed(term)
        for guess, shapes in initial_guesses(term, self.suggestions(effect)):
            yield _Block(self.columns(term, guess, shapes), guess, shapes, signs)

    def columns(self, term: Term, guess: Floats, shapes: Floats) -> Floats:
        """(r, instances * c) weighted rows of `effect_columns`."""
        key, known = (term.name, guess.tobytes(), shapes.tobytes()), self._known_columns
        if known is None:
            return self._computed_columns(term, guess, shapes)
        if key not in known:
            known[key] = self._computed_columns(term, guess, shapes)
        return known[key]

    def orthogonal(self, columns: Floats) -> Floats:
        """The part of `columns` (r, k) outside of the column space of the model."""
        outside: Floats = columns - self._basis @ (self._basis.T @ columns)
        outside -= self._basis @ (self._basis.T @ outside)
        return outside

    def _computed_columns(self, term: Term, guess: Floats, shapes: Floats) -> Floats:
        key = (term.name, guess.tobytes(), shapes.tobytes())
        columns = self._known.get(key) or self._columns_of_recordings(term, guess, shapes)
        if isinstance(term.effect, Signal):
            self._known[key] = columns
        pairs = zip(columns, self._solution.weights, strict=True)
        return np.concatenate([np.nan_to_num(each[w > 0]) * w[w > 0][:, None] for each, w in pairs])

    def _columns_of_recordings(self, term: Term, guess: Floats, shapes: Floats) -> tuple[Floats, ...]:
        """(m, dof, instances * c) `effect_columns` of each training recording."""
        solution = self._solution
        return tuple(
            effect_columns(predictor, solution, term, guess, shapes, predictor.prepared.torque - residual)
            for predictor, residual in zip(self._predictors, solution.residuals, strict=True)
        )

    def suggestions(self, effect: Effect) -> list[Suggestion]:
        """Initial guesses that the effect suggests from the residual of each recording."""
        return suggestions(effect, self._predictors, self._solution, self._residuals)

    def _evaluate(self, name: str, effect: Effect, block: _Block) -> Candidate | Exclusion:
        """The best joints for `block`, or the reason why there are none."""
        c = block.scale.shape[1]
        size = np.sqrt((block.columns**2).sum(axis=0))
        orthogonal = self.orthogonal(block.columns)
        excited = np.sqrt((orthogonal**2).sum(axis=0)) > MIN_EXCITATION * size
        everywhere = Term.on_all_joints(name, effect, self._solution.structure.rig)
        instances = [
            instance
            for instance in range(len(size) // c)
            if excited[instance * c : instance * c + c].any() and size.any()
        ]
        products = Products(
            orthogonal.T @ orthogonal,
            orthogonal.T @ self.residual,
            block.one_signed,
            self._replaced(everywhere, block),
        )
        chosen = choose_joints(products, instances)
        if chosen is None:
            return "sign" if instances else "collinear"
        term, shapes = everywhere, block.shapes
        if not effect.whole_robot:
            term = replace(everywhere, joints=tuple(everywhere.joints[i] for i in chosen.subset))
        if effect.local_shapes:
            shapes = shapes.reshape(everywhere.instances, -1)[list(chosen.subset)].ravel()
        scale, coefficients = block.scale[list(chosen.subset)], chosen.coefficients
        guesses = [np.concatenate([(coefficients.reshape(-1, c) * scale).ravel(), shapes])]
        if isinstance(effect, Signal) and not (np.abs(np.log(np.abs(coefficients) + _TINY)) < _LINEAR_RANGE).all():
            linearized_at = (np.sign(coefficients).reshape(-1, c) * scale).ravel()
            guesses.append(np.concatenate([linearized_at, shapes]))
        parameter_count = len(chosen.subset) * c + sum(shape.searched for shape in term.shapes)
        loss = max(self.loss - chosen.reduction, 0.0)
        return Candidate(term, tuple(guesses), loss, parameter_count, coefficients, scale, shapes)

    def _replaced(self, term: Term, block: _Block) -> Replaced | None:
        """What it costs to remove the friction of the mechanism that the effect replaces, on each of its joints."""
        if term.effect.replaces is None:
            return None
        names = [entry.name for entry in self._solution.structure.parameters]
        entries = [names.index(f"{term.effect.replaces}{joint + 1}") for joint in term.joints]
        # Of a matrix A, column j of pinv(A)' is orthogonal to all columns of A but the column j.
        dual = self._basis @ self._dual[:, entries]
        return Replaced(dual.T @ dual, dual.T @ block.columns, self._solution.x[entries] + dual.T @ self.residual)

    @cached_property
    def _dual(self) -> Floats:
        """(k, K) transposed pseudoinverse of the model's regressor, in coordinates of the basis."""
        dual: Floats = np.zeros((len(self._triangle), len(self._used)))
        dual[:, self._used] = np.linalg.pinv(self._triangle).T / self._size[self._used]
        return dual


def one_signed(term: Term) -> Floats:
    """(c,) 1 where only a positive local parameter is possible, -1 where only a negative one is, else 0."""
    return np.array([float(q.lower >= 0) - float(q.upper <= 0) for q in term.local_parameters])


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


def _merge_guesses(candidates: Sequence[Candidate]) -> Candidate:
    """The first of the `candidates`, with the initial guesses of all that act on the same joints."""
    best = candidates[0]
    guesses = [
        guess for candidate in candidates if candidate.term == best.term for guess in candidate.initial_guesses
    ]
    return replace(best, initial_guesses=tuple(guesses))
