"""All parameters of a composition together, by weighted least squares: Levenberg's and Marquardt's method, in which
the linear ones need no start.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics.structure import ModelStructure
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

_STEPS = 15
_PATIENCE = 2
"""Steps without success: the load, which the effects see, may first have to settle."""
_STUCK = 1e3
"""Damping from which on no step will do."""
_CONVERGED = 1e-4
"""Relative fall of the weighted sum of squares that is not worth another step."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A composition fitted to some recordings."""

    structure: ModelStructure
    x: Floats
    """(K,)"""
    residuals: tuple[Floats, ...]
    """(m, dof) measured minus computed of each recording [N m]; NaN where there is no measurement."""
    derivatives: tuple[Floats, ...]
    """(m, dof, K) of the computed torque by `x`."""
    weights: tuple[Floats, ...]
    """(m, dof) 1 / [N m]; 0 where there is no measurement."""

    @property
    def loss(self) -> float:
        """Weighted sum of squares."""
        return sum(float(np.nansum((w * r) ** 2)) for w, r in zip(self.weights, self.residuals, strict=True))

    def rows(self) -> tuple[Floats, Floats]:
        """Weighted derivatives (r, K) and residuals (r,) of all recordings, where there is a measurement."""
        parts = zip(self.weights, self.derivatives, self.residuals, strict=True)
        stacked = [((w[:, :, None] * d)[w > 0], (w * r)[w > 0]) for w, d, r in parts]
        return np.concatenate([a for a, _ in stacked]), np.concatenate([b for _, b in stacked])


def nonlinear_least_squares(
    evaluators: Sequence[TorquePredictor], composition: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """The parameters with the least weighted squares, found from `x` (K,), of whose linear part nothing is expected.

    weights: (m, dof) for each recording, in 1 / [N m], 0 where there is no measurement.
    """
    return levenberg_marquardt(evaluators, initial_solution(evaluators, composition, x, weights), weights)


def initial_solution(
    evaluators: Sequence[TorquePredictor], composition: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """Where `refine` begins: the linear parameters fitted, the others as in `x` (K,)."""
    x = _within(composition, x)
    own = composition.parameter_mask(-1)
    if not x[own].any():
        bare = replace(composition, terms=())
        x = x.copy()
        x[own] = _linear_part(evaluators, bare, np.zeros(len(bare.parameters)), weights).x
    return _linear_part(evaluators, composition, x, weights)


def levenberg_marquardt(evaluators: Sequence[TorquePredictor], state: Solution, weights: Sequence[Floats]) -> Solution:
    """What `refine` makes of what it has `begun`."""
    composition = state.structure
    if composition.linear.all() and not any(term.effect.axis == "load" for term in composition.terms):
        return state
    free = np.array([entry.free for entry in composition.parameters])
    best, damping, idle = state, 1e-3, 0
    for _ in range(_STEPS):
        trial = _within(composition, state.x + _solve(state, free, damping))
        # By the load as it was: the linearised model knows no other.
        fallen = 1 - _loss(evaluators, composition, trial, state) / state.loss if state.loss else 0.0
        if fallen <= 0:
            if damping > _STUCK or fallen > -_CONVERGED:
                break
            damping = max(10 * damping, 1e-2)
            continue
        state, damping = _state(evaluators, composition, trial, weights), damping / 10
        idle = 0 if state.loss < best.loss * (1 - _CONVERGED) else idle + 1
        best = min(best, state, key=lambda one: one.loss)
        if idle > _PATIENCE or (idle and fallen < _CONVERGED):
            break
    return best


def _linear_part(
    evaluators: Sequence[TorquePredictor], composition: ModelStructure, x: Floats, weights: Sequence[Floats]
) -> Solution:
    """With the linear parameters solved for, the others as in `x`; twice, for the load depends on them."""
    for _ in range(2):
        state = _state(evaluators, composition, x, weights, nonlinear=False)
        x = state.x + _solve(state, composition.linear)
    return _state(evaluators, composition, x, weights)


def _state(
    evaluators: Sequence[TorquePredictor],
    composition: ModelStructure,
    x: Floats,
    weights: Sequence[Floats],
    nonlinear: bool = True,
) -> Solution:
    found = [one.linearized(composition, x, nonlinear) for one in evaluators]
    derivatives = tuple(by_x for _, by_x in found)
    residuals = tuple(one.prepared.dataset.torque - torque for one, (torque, _) in zip(evaluators, found, strict=True))
    known = tuple(
        np.where(np.isfinite(r) & np.isfinite(d).all(axis=2), w, 0.0)
        for r, d, w in zip(residuals, derivatives, weights, strict=True)
    )
    return Solution(composition, x, residuals, derivatives, known)


def _loss(evaluators: Sequence[TorquePredictor], composition: ModelStructure, x: Floats, before: Solution) -> float:
    """Weighted sum of squares at `x` (K,), the load and the rows being those of the solution `before`."""
    rigid = composition.load_parameters(before.x)
    total = 0.0
    for evaluator, weight in zip(evaluators, before.weights, strict=True):
        left = weight * (evaluator.prepared.dataset.torque - evaluator.torque(composition, x, rigid))
        total += float(np.nansum(left**2))
    return total


def _solve(state: Solution, free: Bools, damping: float = 0.0) -> Floats:
    """(K,) step of the `free` parameters (K,) that the linearised model asks for."""
    regressor, residual = state.rows()
    regressor = regressor[:, free]
    size = np.sqrt((regressor**2).sum(axis=0))
    size[size == 0] = 1.0
    scaled = regressor / size
    gram, right = scaled.T @ scaled, scaled.T @ residual
    step = np.zeros(len(free))
    step[free] = np.linalg.lstsq(gram + damping * np.eye(len(gram)), right, rcond=1e-12)[0] / size
    return step


def _within(composition: ModelStructure, x: Floats) -> Floats:
    """`x` with its searched parameters inside their physical range."""
    lower = np.array([entry.lower if not entry.linear else -np.inf for entry in composition.parameters])
    upper = np.array([entry.upper if not entry.linear else np.inf for entry in composition.parameters])
    return np.clip(x, lower, upper)
