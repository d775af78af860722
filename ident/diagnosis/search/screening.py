"""Screen all effects of the library for what they could explain of a residual, by linear algebra alone.

The columns of each candidate, at every initial shape, are projected onto the orthogonal complement of the model's
regressor, including the effects already in it. The projected columns then give the reduction of the loss, as in
orthogonal forward selection. Correlation with the residual alone is not used.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, product

import numpy as np

from ident.basics.threads import in_threads
from ident.diagnosis.search.joint_subsets import Products, choose_joints
from ident.diagnosis.search.selection import WIDTH, Exclusion
from ident.diagnosis.split.split_data import TINY, SplitData
from ident.dynamics.effects.base import Effect, Suggestion
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from ident.estimation.shape_parameters import guess_scales, suggestions
from recordings.recording import Floats

MIN_EXCITATION = 1e-3
"""A column is not excited if its part outside of the model's column space is below this share of its size."""
_LINEAR_RANGE = 0.7
"""The coefficient of a nonlinear effect may differ from the linearization point by this much (natural logarithm)
before that point becomes a second initial guess."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An effect on some joints, with initial guesses of its parameters."""

    term: Term
    initial_guesses: tuple[Floats, ...]
    """(local + shapes,) entries of the parameter vector: by linear extrapolation, and the linearization point if it
    differs."""
    loss: float
    """Expected weighted sum of squares with the candidate."""
    coefficients: Floats
    """(instances * c,) of its columns, by linear extrapolation."""
    scale: Floats
    """(instances, c) local parameter per unit of column coefficient at the linearization point."""
    shapes: Floats
    """(s,) shape parameters of its columns."""
    elsewhere: tuple["Candidate", ...] = ()
    """The effect on other joints, which linear extrapolation does not tell from these."""

    @property
    def parameter_count(self) -> int:
        """Number of its local parameters, including optimized shapes."""
        return self.scale.size + sum(shape.searched for shape in self.term.shapes)

    @property
    def local_values(self) -> Floats:
        """(instances, c) local parameters, by linear extrapolation."""
        return self.coefficients.reshape(self.scale.shape) * self.scale


@dataclass(frozen=True, eq=False)
class Screening:
    """What a library could add to one model."""

    candidates: tuple[Candidate, ...]
    """The most promising first."""
    excluded: Mapping[str, Exclusion]
    """Effects that cannot be added, with the reason."""
    loss: float
    """Of the model."""

    @cached_property
    def best(self) -> dict[str, Candidate]:
        """The most promising candidate of each effect."""
        return {candidate.term.name: candidate for candidate in reversed(self.candidates)}

    @property
    def reductions(self) -> dict[str, float]:
        """Relative reduction of the loss that each effect promises."""
        return {name: 1 - candidate.loss / self.loss for name, candidate in self.best.items()}


ColumnsKey = tuple[str, tuple[int, ...], bytes, bytes]
"""Name and joints of an effect, and the local parameters and shapes at which its columns are computed."""


class Screener:
    """Screens candidates against one model."""

    def __init__(
        self, split: SplitData, solution: Solution, known: dict[ColumnsKey, tuple[Floats, ...]] | None = None
    ) -> None:
        """`known`: columns of signal effects beside other models of the same data, which hardly differ from them."""
        self._solution, self._known = solution, {} if known is None else known
        self.regressor, self.residual = solution.rows()
        self._basis = column_basis(self.regressor)
        self.loss = solution.loss
        self.residuals = solution.residuals
        self._predictors = split.train_predictors
        self._keeps_all = False
        """Columns are kept only if several residuals are screened: those of a long recording take much memory."""

    def with_residuals(self, residuals: Sequence[Floats]) -> "Screener":
        """Screener of the same model for other `residuals` (m, dof) of each training recording [N m].

        The torque of the model stays what it is, so that columns are computed once for all of them.
        """
        self._keeps_all = True
        other = copy(self)
        other.residuals = tuple(residuals)
        other.residual = np.concatenate(
            [
                (weight * residual)[weight > 0]
                for weight, residual in zip(self._solution.weights, residuals, strict=True)
            ]
        )
        other.loss = float(other.residual @ other.residual)
        return other

    def screen(self, library: Mapping[str, Effect]) -> Screening:
        """The best candidate of every effect, and the reason why others are excluded.

        Effects that may occur several times have several candidates.
        """
        best: list[Candidate] = []
        excluded: dict[str, Exclusion] = {}
        all_results = in_threads(self._results, library.keys(), library.values())
        for (name, effect), results in zip(library.items(), all_results, strict=True):
            found = (candidate for candidate in results if isinstance(candidate, Candidate))
            if candidates := sorted(found, key=lambda candidate: candidate.loss):
                best += candidates[:WIDTH] if effect.repeated else [self._merged(candidates)]
            else:
                excluded[name] = "sign" if "sign" in results else "collinear"
        return Screening(tuple(sorted(best, key=lambda candidate: candidate.loss)), excluded, self.loss)

    def _results(self, name: str, effect: Effect) -> list[Candidate | Exclusion]:
        """A candidate for each initial guess of the shapes of `effect`, or the reason why there is none."""
        term = Term.on_all_joints(name, effect, self._solution.structure.rig)
        guesses = initial_guesses(term, self.suggestions(effect), self.guess_scales(term))
        return [self._evaluate(term, *guess) for guess in guesses]

    def columns(self, term: Term, guess: Floats, shapes: Floats) -> Floats:
        """(r, instances * c) weighted rows of `effect_columns`."""
        weighted = zip(self._of_recordings(term, guess, shapes), self._solution.weights, strict=True)
        return np.concatenate([np.nan_to_num(each[w > 0]) * w[w > 0][:, None] for each, w in weighted])

    def _of_recordings(self, term: Term, guess: Floats, shapes: Floats) -> tuple[Floats, ...]:
        """`effect_columns` of each training recording."""
        if len(guess) > 1 and not (term.effect.linear or term.effect.local_shapes):
            alone = (  # one joint at a time: some are known
                self._of_recordings(replace(term, joints=(joint,)), values[None], shapes)
                for joint, values in zip(term.joints, guess, strict=True)
            )
            return tuple(np.concatenate(each, axis=2) for each in zip(*alone, strict=True))
        key = (term.name, term.joints, guess.tobytes(), shapes.tobytes())
        columns = self._known.get(key) or tuple(
            effect_columns(predictor, self._solution, term, guess, shapes, predictor.prepared.torque - residual)
            for predictor, residual in zip(self._predictors, self._solution.residuals, strict=True)
        )
        if self._keeps_all or not term.effect.linear:
            self._known[key] = columns
        return columns

    def orthogonal(self, columns: Floats) -> Floats:
        """The part of `columns` (r, k) outside of the column space of the model."""
        return _outside(self._basis, columns)

    def suggestions(self, effect: Effect) -> list[Suggestion]:
        """Initial guesses that the effect suggests from the residual of each recording."""
        return suggestions(effect, self._predictors, self._solution, self.residuals)

    def guess_scales(self, term: Term) -> Floats:
        """Factors (instances, 1) of the initial guesses of a `term`."""
        return guess_scales(term, self._predictors[0], self._solution)

    def _evaluate(self, everywhere: Term, scale: Floats, shapes: Floats) -> Candidate | Exclusion:
        """The effect on the best of its joints, or the reason why there are none.

        scale: (instances, c) local parameters at which its columns are made.
        """
        columns, effect, c = self.columns(everywhere, scale, shapes), everywhere.effect, scale.shape[1]
        size, outside = np.sqrt((columns**2).sum(axis=0)), self.orthogonal(columns)
        excited = np.sqrt((outside**2).sum(axis=0)) > MIN_EXCITATION * size
        instances = np.flatnonzero(excited.reshape(-1, c).any(axis=1)).tolist() if size.any() else []
        chosen = choose_joints(self._products(everywhere, columns, outside), instances)
        if chosen is None:
            return "sign" if instances else "collinear"
        subset, reduction, coefficients = list(chosen[0]), chosen[1], chosen[2]
        on_subset = replace(everywhere, joints=tuple(everywhere.joints[i] for i in subset))
        if effect.local_shapes:
            shapes = shapes.reshape(everywhere.instances, -1)[subset].ravel()
        scale = scale[subset]
        guesses = [np.concatenate([(coefficients.reshape(-1, c) * scale).ravel(), shapes])]
        if not effect.linear and not (np.abs(np.log(np.abs(coefficients) + TINY)) < _LINEAR_RANGE).all():
            guesses.append(np.concatenate([(np.sign(coefficients).reshape(-1, c) * scale).ravel(), shapes]))
        loss, term = max(self.loss - reduction, 0.0), everywhere if effect.whole_robot else on_subset
        return Candidate(term, tuple(guesses), loss, coefficients, scale, shapes)

    def _merged(self, candidates: Sequence[Candidate]) -> Candidate:
        """The first of the `candidates`, with the initial guesses of the next ones that act on the same joints.

        Where joints differ by orders of magnitude, the best on other joints are kept as well.
        """
        best, effect = candidates[0], candidates[0].term.effect
        same = (each.initial_guesses for each in candidates[: effect.multistart] if each.term == best.term)
        others = {each.term: each for each in reversed(candidates) if each.term != best.term}
        everywhere = Term.on_all_joints(best.term.name, effect, self._solution.structure.rig)
        kept = WIDTH - 1 if np.ptp(self.guess_scales(everywhere)) else 0
        elsewhere = sorted(others.values(), key=lambda each: each.loss)[:kept]
        return replace(best, initial_guesses=tuple(chain.from_iterable(same)), elsewhere=tuple(elsewhere))

    def replaced(self, term: Term) -> list[int]:
        """Columns of the model in whose place the `term` stands."""
        names = [parameter.name for parameter in self._solution.structure.parameters]
        return [names.index(f"{term.effect.replaces}{joint + 1}") for joint in term.joints if term.effect.replaces]

    def _products(self, term: Term, columns: Floats, outside: Floats) -> Products:
        """Products of the `columns` (r, instances * c) of the `term`, and of those in whose place it stands.

        outside: the part of the columns outside of the column space of the model.
        """
        both, target, replaced = outside, self.residual, self.replaced(term)
        if replaced:
            basis = column_basis(np.delete(self.regressor, replaced, axis=1))
            target = target + self.regressor[:, replaced] @ self._solution.x[replaced]
            target = _outside(basis, target[:, None])[:, 0]
            both = _outside(basis, np.concatenate([columns, self.regressor[:, replaced]], axis=1))
        return Products(
            both.T @ both,
            both.T @ target,
            float(target @ target - self.residual @ self.residual),
            np.array([float(q.lower >= 0) - float(q.upper <= 0) for q in term.local_parameters]),
            np.arange(columns.shape[1], both.shape[1]),
        )


def column_basis(regressor: Floats) -> Floats:
    """(r, k) orthonormal basis of the column space of `regressor` (r, K)."""
    size = np.sqrt((regressor**2).sum(axis=0))
    return np.linalg.qr(regressor[:, size > 0] / size[size > 0])[0]


def _outside(basis: Floats, columns: Floats) -> Floats:
    """The part of `columns` (r, k) outside of the space of an orthonormal `basis`."""
    outside: Floats = columns - basis @ (basis.T @ columns)
    outside -= basis @ (basis.T @ outside)
    return outside


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

    if term.effect.linear:
        return predictor.conditioned_columns(structure, len(structure.terms) - 1, at(np.zeros(local.size)), load)
    changes = [predictor.torque(structure, at(values), load) - computed for values in np.diag(local.ravel())]
    return np.stack(changes, axis=2)


def initial_guesses(
    term: Term, suggestions: Sequence[Suggestion], scales: Floats | float = 1.0
) -> list[tuple[Floats, Floats]]:
    """Local parameters (instances, c) and shapes (s,) at which columns of the `term` are made.

    They are those that its effect declares, times their `scales` (instances, 1), and its `suggestions` from the
    residuals.
    """
    effect = term.effect
    first_parameter = effect.parameters[0].name
    shapes = term.shape_guesses([suggestion for suggestion in suggestions if first_parameter not in suggestion])
    guesses = [quantity.initial_guesses or (1.0,) for quantity in term.local_parameters]
    count = max(map(len, guesses))  # where a parameter has fewer, its last one stays
    starts = [np.array([each[min(i, len(each) - 1)] for each in guesses]) for i in range(count)]
    pairs = [
        *((scales * np.tile(start, (term.instances, 1)), values) for start, values in product(starts, shapes)),
        *(
            (
                np.stack([np.broadcast_to(each[q.name], term.instances) for q in term.local_parameters], axis=1),
                np.array([each[shape.name] for shape in effect.shapes], float),
            )
            for each in suggestions
            if first_parameter in each
        ),
    ]
    # Several recordings may suggest the same.
    return list({(start.tobytes(), values.tobytes()): (start, values) for start, values in pairs}.values())
