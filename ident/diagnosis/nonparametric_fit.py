"""Learns the curves that stand in for what remains: smooth, shrunk, and borne out by rows that no fit has seen."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.diagnosis.improvement import Improvement, measure_improvement
from ident.diagnosis.noise_floor import estimate_noise_floor
from ident.diagnosis.residual_dependence import Dependence
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import FittedModel
from ident.diagnosis.stepwise_selection import is_supported
from ident.diagnosis.unexplained_residual import estimate_unexplained
from ident.dynamics.effect_inputs import View
from ident.dynamics.effects.learned_curve import Curve, effect_of
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import Evaluator
from recordings.recording import Bools, Floats

KNOTS = 17
SMOOTHNESS = tuple(10.0**power for power in range(-4, 5))
"""Weights of the second difference that are tried, over the mean square of a column."""
BLOCK_SECONDS = 1.0
"""Of every two stretches this long [s], one tells how smooth a curve that is learned from the other should be."""
_SHRUNK = 1e-3
_TINY = 1e-6


@dataclass(frozen=True, eq=False)
class NonparametricFit:
    """Curves, and what they are worth."""

    curves: tuple[Curve, ...]
    dependences: tuple[Dependence, ...]
    """What they are over."""
    model: FittedModel
    """The last model with them."""
    improvement: Improvement
    """On rows that no fit has seen."""

    @property
    def supported(self) -> bool:
        """Whether those rows bear the curves out."""
        return is_supported(self.improvement)


@dataclass(frozen=True, eq=False)
class _Rows:
    """What fits see, of all recordings and joints."""

    hats: Floats
    """(r, curves * KNOTS)"""
    model: Floats
    """(r, K) what the model's own parameters can do."""
    residual: Floats
    """(r,)"""
    first: Bools
    """(r,) of which half they are."""
    bend: Floats
    """(b, curves * KNOTS) changes of slope per value at each knot."""

    def solved(self, which: Bools, smoothness: float) -> Floats:
        """(K + curves * KNOTS,) scaled model parameters, and values at the knots."""
        matrix = np.concatenate([self.model[which], self.hats[which]], axis=1)
        # Of all rows: a half in which a curve is not visited must not leave its knots without any weight.
        level = float(np.mean(self.hats**2))
        penalty = np.diag(np.r_[np.full(self.model.shape[1], _TINY), np.full(self.hats.shape[1], _SHRUNK * level)])
        part = slice(self.model.shape[1], None)
        penalty[part, part] += smoothness * level * self.bend.T @ self.bend
        gram = matrix.T @ matrix + max(len(matrix), 1) * penalty
        solution: Floats = np.linalg.solve(gram, matrix.T @ self.residual[which])
        return solution

    def error(self, smoothness: float) -> float:
        """Mean square that either half leaves of the other."""
        total = 0.0
        for which in (self.first, ~self.first):
            matrix = np.concatenate([self.model[~which], self.hats[~which]], axis=1)
            total += float(np.sum((self.residual[~which] - matrix @ self.solved(which, smoothness)) ** 2))
        return total


def fit_curves(material: SplitData, top: FittedModel) -> NonparametricFit | None:
    """The curves that stand in for what the model `top` leaves; None where it depends on nothing that has one.

    One joint comes after the other, the one with most of it first, and before all what changes with time: only once a
    joint has its curve is seen what the others lack themselves.
    """
    reached = estimate_noise_floor(material, top.solution, top.residuals)
    used: list[Dependence] = []
    curves: list[Curve] = []
    after = top
    for _ in range(top.residuals[0].shape[1]):
        left = estimate_unexplained(material, after, estimate_noise_floor(material, after.solution, after.residuals))
        share = left.rms / material.torque_rms
        more = [one for one in left.dependences if one.joint not in {other.joint for other in used}]
        if not more:
            break
        used.append(max(more, key=lambda one: ("time" in one.variables, share[one.joint])))
        curves = _learned(material, top.solution, [curve for one in used for curve in _blank(one)])
        after = _beside(material, top, curves)
    if not curves:
        return None
    held_out = measure_improvement(material, top.residuals, after.residuals, reached.rms)
    return NonparametricFit(tuple(curves), tuple(used), after, held_out)


def _beside(material: SplitData, top: FittedModel, curves: Sequence[Curve]) -> FittedModel:
    """The model `top` with `curves`, refitted."""
    joints = tuple(sorted({curve.joint - 1 for curve in curves}))
    composition = top.solution.composition.plus(Term("stand_in", effect_of(curves), joints))
    solution = material.fit(composition, np.concatenate([top.solution.x, np.ones(len(joints))]))
    return FittedModel(solution, material.residuals(solution))


def _blank(one: Dependence) -> list[Curve]:
    """Curves without knots over what was found."""
    return [Curve(one.joint + 1, own.variable, own.joint + 1, own.times, (), ()) for own in one.inputs]


def _learned(material: SplitData, solution: Solution, blank: Sequence[Curve]) -> list[Curve]:
    """All together, while the model's own parameters move along."""
    views = [_view(material.predictors[i], solution) for i in material.train_indices]
    curves = [replace(curve, knots=_knots(curve, views)) for curve in blank]
    rows = _rows(material, solution, views, curves)
    best = min(SMOOTHNESS, key=rows.error)
    values = rows.solved(np.ones(len(rows.residual), bool), best)[rows.model.shape[1] :].reshape(-1, KNOTS)
    return [replace(curve, values=tuple(map(float, own))) for curve, own in zip(curves, values, strict=True)]


def _view(evaluator: Evaluator, solution: Solution) -> View:
    composition, x = solution.composition, solution.x
    return evaluator.view(evaluator.path(composition, x), composition.load(x))


def _knots(curve: Curve, views: Sequence[View]) -> tuple[float, ...]:
    """Over all that was visited, the closer the more often it was visited."""
    signal = np.concatenate([curve.signal(view) for view in views])
    share = np.linspace(0.0, 1.0, KNOTS)
    often = np.nanquantile(signal, share)
    knots: Floats = (often + np.linspace(often[0], often[-1], KNOTS)) / 2
    return tuple(knots.tolist())


def _bend(knots: Sequence[float]) -> Floats:
    """(KNOTS - 2, KNOTS) change of slope at each inner knot, in units of the mean distance of knots."""
    distance = np.diff(knots) / np.mean(np.diff(knots))
    slope = np.diff(np.eye(KNOTS), axis=0) / distance[:, None]
    change: Floats = np.diff(slope, axis=0)
    return change


def _rows(material: SplitData, solution: Solution, views: Sequence[View], curves: Sequence[Curve]) -> _Rows:
    from scipy.linalg import block_diag

    parts = []
    pairs = zip(material.train_indices, views, solution.derivatives, solution.residuals, strict=True)
    for index, view, derivatives, residual in pairs:
        hats = material.predictors[index].course.condition(_hats(curves, view))
        seen = material.train[index] & np.isfinite(residual)
        seen &= np.isfinite(hats).all(axis=2) & np.isfinite(derivatives).all(axis=2)
        first = np.floor(material.datasets[index].time / BLOCK_SECONDS) % 2 == 0
        first = np.repeat(first[:, None], seen.shape[1], axis=1)
        parts.append((hats[seen], derivatives[seen], residual[seen], first[seen]))
    hats, model, residual, first = (np.concatenate(part) for part in zip(*parts, strict=True))
    size = np.sqrt(np.mean(model**2, axis=0))
    bend = block_diag(*(_bend(curve.knots) for curve in curves))
    return _Rows(hats, model[:, size > 0] / size[size > 0], residual, first, bend)


def _hats(curves: Sequence[Curve], view: View) -> Floats:
    """(n, dof, curves * KNOTS) torque per unit of the value at each knot."""
    n, dof = view.motion.velocity.shape
    hats = np.zeros((n, dof, len(curves), KNOTS))
    for number, curve in enumerate(curves):
        signal = curve.signal(view)
        place = np.interp(np.nan_to_num(signal), curve.knots, np.arange(KNOTS))
        weight = np.where(np.isfinite(signal), curve.factor(view), np.nan)
        hats[:, curve.joint - 1, number] = np.maximum(1 - np.abs(place[:, None] - np.arange(KNOTS)), 0.0)
        hats[:, curve.joint - 1, number] *= weight[:, None]
    return hats.reshape(n, dof, -1)
