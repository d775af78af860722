"""Nonlinear least squares: the Levenberg-Marquardt method for all parameters of a model structure.

The linear parameters need no initial guess.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from ident.basics.statistics import nonzero
from ident.basics.threads import in_threads
from ident.dynamics.structure import ModelStructure
from ident.estimation import possible_links
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

_MAX_STEPS = 15
_PATIENCE = 2
"""Steps without improvement. The load parameters, on which effects depend, may have to converge first."""
_MAX_DAMPING = 1e3
"""Damping above which no further step is tried."""
_CONVERGED = 1e-4
"""Relative reduction of the weighted sum of squares below which the iteration ends."""
_MAX_ESCAPES = 4
"""Most escapes from local minima."""
_NEIGHBORS = (0.8, 0.9, 0.95, 1.05, 1.1, 1.25)
"""Multiples of a parameter at which a lower local minimum is looked for."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A model structure fitted to recordings."""

    structure: ModelStructure
    x: Floats
    """(K,)"""
    residuals: tuple[Floats, ...]
    """(m, dof) measured minus predicted torque of each recording [N m]; NaN where there is no measurement."""
    derivatives: tuple[Floats, ...]
    """(m, dof, K) derivatives of the predicted torque of each recording with respect to `x`."""
    weights: tuple[Floats, ...]
    """(m, dof) weights of each recording [1 / (N m)]; 0 where there is no measurement or no prediction."""
    row_count: int
    """Number of rows to which it was fitted; in some of them the model may predict nothing."""

    @property
    def loss(self) -> float:
        """Weighted sum of squares."""
        return _loss(self.residuals, self.weights, self.row_count)

    def rows(self) -> tuple[Floats, Floats]:
        """Weighted derivatives (r, K) and residuals (r,) of all measured rows of all recordings."""
        recordings = zip(self.weights, self.derivatives, self.residuals, strict=True)
        stacked = [((w[:, :, None] * d)[w > 0], (w * r)[w > 0]) for w, d, r in recordings]
        return np.concatenate([a for a, _ in stacked]), np.concatenate([b for _, b in stacked])


def nonlinear_least_squares(
    predictors: Sequence[TorquePredictor], structure: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """Minimise the weighted sum of squares, starting from `x` (K,), whose linear parameters may be arbitrary.

    weights: (m, dof) of each recording [1 / (N m)]; 0 where there is no measurement.
    """
    return levenberg_marquardt(predictors, initial_solution(predictors, structure, x, weights), weights)


def initial_solution(
    predictors: Sequence[TorquePredictor], structure: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """Fit the linear parameters, with the nonlinear parameters of `x` (K,): the start of the iteration."""
    x = _within(structure, x)
    mechanism = structure.parameter_mask(-1)
    if not x[mechanism].any():
        bare = replace(structure, terms=())
        x = x.copy()
        x[mechanism] = _solve_linear(predictors, bare, np.zeros(len(bare.parameters)), weights).x
    return _solve_linear(predictors, structure, x, weights)


def levenberg_marquardt(
    predictors: Sequence[TorquePredictor], solution: Solution, weights: Sequence[Floats]
) -> Solution:
    """Iterate from a `solution` by the Levenberg-Marquardt method and return the best solution."""
    structure = solution.structure
    if structure.linear.all() and not any(term.effect.axis == "load" for term in structure.terms):
        return solution
    free = np.array([entry.free for entry in structure.parameters])
    best, damping, idle_steps = solution, 1e-3, 0
    for _ in range(_MAX_STEPS):
        trial = _within(structure, solution.x + _solve(solution, free, damping))
        # With the load parameters of the current solution, as in the linearized model.
        reduction = 1 - _trial_loss(predictors, structure, trial, solution) / solution.loss if solution.loss else 0.0
        if reduction <= 0:
            if damping > _MAX_DAMPING or reduction > -_CONVERGED:
                break
            damping = max(10 * damping, 1e-2)
            continue
        solution, damping = linearized_solution(predictors, structure, trial, weights), damping / 10
        idle_steps = 0 if solution.loss < best.loss * (1 - _CONVERGED) else idle_steps + 1
        best = min(best, solution, key=lambda candidate: candidate.loss)
        if idle_steps > _PATIENCE or (idle_steps and reduction < _CONVERGED):
            break
    return best


def escape_local_minima(
    predictors: Sequence[TorquePredictor], solution: Solution, weights: Sequence[Floats]
) -> Solution:
    """Improve a `solution` that may be a local minimum over the searched parameters of discontinuous effects.

    Where the torque is discontinuous (an arm leaves its tooth at one instant, or not at all), small steps of the
    loss stop the Levenberg-Marquardt method. Each parameter is tried at multiples of its value, and so are two of an
    effect together, which a narrow valley may connect; the iteration goes on from the best of them, as long as that
    reduces the loss.
    """
    terms = solution.structure.terms
    searched = np.array(
        [
            not entry.linear and entry.term >= 0 and terms[entry.term].effect.discontinuous
            for entry in solution.structure.parameters
        ]
    )
    for _ in range(_MAX_ESCAPES if searched.any() else 0):
        start = _best_neighbor(predictors, solution, searched)
        if start is None:
            return solution
        escaped = nonlinear_least_squares(predictors, solution.structure, start, weights)
        if escaped.loss > solution.loss * (1 - _CONVERGED):
            return solution
        solution = escaped
    return solution


def _best_neighbor(predictors: Sequence[TorquePredictor], solution: Solution, searched: Bools) -> Floats | None:
    """Vector (K,) with one of the `searched` (K,) parameters changed and the least loss; None: none is less."""
    structure, load_parameters = solution.structure, solution.structure.load_parameters(solution.x)
    linear_columns = np.linalg.qr(solution.rows()[0][:, structure.linear])[0]

    def loss(x: Floats) -> float:
        """Sum of squares after the linear parameters are fitted, which hardly change the other columns."""
        residuals = [each.prepared.torque - each.torque(structure, x, load_parameters) for each in predictors]
        pairs = zip(solution.weights, residuals, strict=True)
        rows = np.concatenate([(w * np.nan_to_num(r))[w > 0] for w, r in pairs])
        return float(rows @ rows - np.sum((linear_columns.T @ rows) ** 2))

    neighbors = []
    for factors in _neighbors(structure, searched):
        x = solution.x.copy()
        for entry, factor in factors.items():
            x[entry] *= factor
        neighbors.append(_within(structure, x))
    losses = in_threads(loss, [solution.x, *neighbors])
    best = int(np.argmin(losses))
    return neighbors[best - 1] if losses[best] < losses[0] * (1 - _CONVERGED) else None


def _neighbors(structure: ModelStructure, searched: Bools) -> Iterator[dict[int, float]]:
    """Multiples of one of the `searched` (K,) parameters, by its entry, or of two of the same effect."""
    entries = np.flatnonzero(searched).tolist()
    yield from ({entry: factor} for entry in entries for factor in _NEIGHBORS)
    for first, second in combinations(entries, 2):
        if structure.parameters[first].term == structure.parameters[second].term:
            yield from ({first: a, second: b} for a, b in product(_NEIGHBORS, repeat=2) if (a < 1) == (b < 1))


def _solve_linear(
    predictors: Sequence[TorquePredictor], structure: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """Solve for the linear parameters, with the others of `x`; twice, as load parameters depend on the solution."""
    for _ in range(2):
        solution = linearized_solution(predictors, structure, x, weights, nonlinear=False)
        x = solution.x + _solve(solution, structure.linear)
    return linearized_solution(predictors, structure, x, weights)


def linearized_solution(
    predictors: Sequence[TorquePredictor],
    structure: ModelStructure,
    x: Floats,
    weights: Sequence[Floats],
    nonlinear: bool = True,
) -> Solution:
    """Linearize the model `structure` at `x` (K,); nonlinear: as in `TorquePredictor.linearized`."""
    linearized = in_threads(lambda predictor: predictor.linearized(structure, x, nonlinear), predictors)
    derivatives = tuple(by_x for _, by_x in linearized)
    residuals = tuple(
        predictor.prepared.torque - torque for predictor, (torque, _) in zip(predictors, linearized, strict=True)
    )
    usable_weights = tuple(
        np.where(np.isfinite(r) & np.isfinite(d).all(axis=2), w, 0.0)
        for r, d, w in zip(residuals, derivatives, weights, strict=True)
    )
    row_count = sum(int((weight > 0).sum()) for weight in weights)
    return Solution(structure, x, residuals, derivatives, usable_weights, row_count)


def _trial_loss(
    predictors: Sequence[TorquePredictor], structure: ModelStructure, x: Floats, before: Solution
) -> float:
    """Weighted sum of squares at `x` (K,), with the load parameters and the rows of the solution `before`."""
    load_parameters = structure.load_parameters(before.x)
    residuals = in_threads(
        lambda predictor: predictor.prepared.torque - predictor.torque(structure, x, load_parameters), predictors
    )
    return _loss(residuals, before.weights, before.row_count)


def _loss(residuals: Sequence[Floats], weights: Sequence[Floats], row_count: int) -> float:
    """Weighted sum of squares, as if the rows without a residual were like the others.

    Otherwise a model would improve by predicting nothing in some rows, as a longer delay does beside gaps.
    """
    total, known_count = 0.0, 0
    for residual, weight in zip(residuals, weights, strict=True):
        total += float(np.nansum((weight * residual) ** 2))
        known_count += int(((weight > 0) & np.isfinite(residual)).sum())
    return total * (row_count / known_count) if known_count else np.inf


def _solve(solution: Solution, free: Bools, damping: float = 0.0) -> Floats:
    """Step (K,) of the `free` parameters (K,) that solves the damped normal equations of the linearized model."""
    regressor, residual = solution.rows()
    regressor = regressor[:, free]
    with np.errstate(over="ignore"):  # a search that diverges takes no step along what is too large
        size = nonzero(np.sqrt((regressor**2).sum(axis=0)))
    scaled = regressor / size
    gram, right = scaled.T @ scaled + damping * np.eye(len(size)), scaled.T @ residual
    step = np.zeros(len(free))
    if links := solution.structure.bodies:
        now = solution.x[: len(links.base.columns)]
        step[free] = possible_links.step(links, gram * np.outer(size, size), right * size, now)
    else:
        step[free] = np.linalg.lstsq(gram, right, rcond=1e-12)[0] / size
    return step


def _within(structure: ModelStructure, x: Floats) -> Floats:
    """Clip the nonlinear parameters of `x` to their physical range."""
    lower = np.array([entry.lower if not entry.linear else -np.inf for entry in structure.parameters])
    upper = np.array([entry.upper if not entry.linear else np.inf for entry in structure.parameters])
    return np.clip(x, lower, upper)
