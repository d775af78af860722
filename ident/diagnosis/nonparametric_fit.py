"""Fit learned curves to an unexplained residual: penalized piecewise linear functions, validated on test rows."""

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
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

KNOTS = 17
SMOOTHNESS = tuple(10.0**power for power in range(-4, 5))
"""Candidate weights of the penalty on the second difference, relative to the mean square of a column."""
BLOCK_SECONDS = 1.0
"""Blocks of this length alternate between the two halves of the cross-validation [s]."""
_SHRUNK = 1e-3
_TINY = 1e-6


@dataclass(frozen=True, eq=False)
class NonparametricFit:
    """Learned curves and the improvement by them."""

    curves: tuple[Curve, ...]
    dependences: tuple[Dependence, ...]
    """The variables of the curves."""
    model: FittedModel
    """The final model with the curves."""
    improvement: Improvement
    """On test rows."""

    @property
    def supported(self) -> bool:
        """Whether the test rows support the curves."""
        return is_supported(self.improvement)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Training rows of all recordings and joints."""

    hats: Floats
    """(r, curves * KNOTS)"""
    regressor: Floats
    """(r, K) of the model's own parameters."""
    residual: Floats
    """(r,)"""
    first_half: Bools
    """(r,) rows of the first half of the cross-validation."""
    slope_changes: Floats
    """(b, curves * KNOTS) change of slope at each inner knot per value at a knot."""

    def solve(self, which: Bools, smoothness: float) -> Floats:
        """(K + curves * KNOTS,) scaled model parameters, and the curves' values at the knots, from the `selected`
        rows.
        """
        matrix = np.concatenate([self.regressor[which], self.hats[which]], axis=1)
        # Of all rows: a half in which a curve is not visited must not leave its knots without any weight.
        level = float(np.mean(self.hats**2))
        penalty = np.diag(np.r_[np.full(self.regressor.shape[1], _TINY), np.full(self.hats.shape[1], _SHRUNK * level)])
        part = slice(self.regressor.shape[1], None)
        penalty[part, part] += smoothness * level * self.slope_changes.T @ self.slope_changes
        gram = matrix.T @ matrix + max(len(matrix), 1) * penalty
        solution: Floats = np.linalg.solve(gram, matrix.T @ self.residual[which])
        return solution

    def cross_validation_error(self, smoothness: float) -> float:
        """Sum of squares of each half, predicted from the other half."""
        total = 0.0
        for which in (self.first_half, ~self.first_half):
            matrix = np.concatenate([self.regressor[~which], self.hats[~which]], axis=1)
            total += float(np.sum((self.residual[~which] - matrix @ self.solve(which, smoothness)) ** 2))
        return total


def fit_curves(material: SplitData, top: FittedModel) -> NonparametricFit | None:
    """Fit curves to the residual of the `final` model; None if it depends on no variable of a curve.

    One joint is added at a time, those that change with time first, then the one with the largest unexplained residual:
    the residuals of the other joints are meaningful only after that.
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
        curves = _fit_values(material, top.solution, [curve for one in used for curve in _empty_curves(one)])
        after = _fit_with_curves(material, top, curves)
    if not curves:
        return None
    held_out = measure_improvement(material, top.residuals, after.residuals, reached.rms)
    return NonparametricFit(tuple(curves), tuple(used), after, held_out)


def _fit_with_curves(material: SplitData, top: FittedModel, curves: Sequence[Curve]) -> FittedModel:
    """Refit the model `final` structureth `curves`."""
    joints = tuple(sorted({curve.joint - 1 for curve in curves}))
    composition = top.solution.composition.plus(Term("stand_in", effect_of(curves), joints))
    solution = material.fit(composition, np.concatenate([top.solution.x, np.ones(len(joints))]))
    return FittedModel(solution, material.residuals(solution))


def _empty_curves(one: Dependence) -> list[Curve]:
    """Curves without knots over the variables of `dependence`."""
    return [Curve(one.joint + 1, own.variable, own.joint + 1, own.times, (), ()) for own in one.inputs]


def _fit_values(material: SplitData, solution: Solution, blank: Sequence[Curve]) -> list[Curve]:
    """Fit all curves together while the model's own parameters adapt."""
    views = [_effect_inputs(material.predictors[i], solution) for i in material.train_indices]
    curves = [replace(curve, knots=_knots(curve, views)) for curve in blank]
    rows = _rows(material, solution, views, curves)
    best = min(SMOOTHNESS, key=rows.cross_validation_error)
    values = rows.solve(np.ones(len(rows.residual), bool), best)[rows.regressor.shape[1] :].reshape(-1, KNOTS)
    return [replace(curve, values=tuple(map(float, own))) for curve, own in zip(curves, values, strict=True)]
TorquePredictor
structure
def _effect_inputs(eveffect_inputstor: Evaluacorrected_motion solution: Solution) -> View:
    composition, x = solution.composition, solution.x
    return evaluator.view(evaluator.path(composition, x), composition.load(x))


def _knots(curve: Curve, views: Sequence[View]) -> tuple[float, ...]:
    """Knots over the visited range, denser where more rows are."""
    signal = np.concatenate([curve.signal(view) for view in views])
    share = np.linspace(0.0, 1.0, KNOTS)
    often = np.nanquantile(signal, share)
    knots: Floats = (often + np.linspace(often[0], often[-1], KNOTS)) / 2
    return tuple(knots.tolist())


def _slope_changes(knots: Sequence[float]) -> Floats:
    """(KNOTS - 2, KNOTS) change of slope at each inner knot, in units of the mean distance of knots."""
    distance = np.diff(knots) / np.mean(np.diff(knots))
    slope = np.diff(np.eye(KNOTS), axis=0) / distance[:, None]
    change: Floats = np.diff(slope, axis=0)
    return change


def _rows(material: SplitData, solution: Solution, views: Sequence[View], curves: Sequence[Curve]) -> _Rows:
    from scipy.linalg import block_diag

    parts = []
    pairs = zip(material.train_indices, vipreparedolution.derivatives, solution.residuals, strict=True)
    for index, view, derivatives, residual in pairs:
        hats = material.predictors[index].course.condition(_hat_functions(curves, view))
        seen = material.train[index] & np.isfinite(residual)
        seen &= np.isfinite(hats).all(axis=2) & np.isfinite(derivatives).all(axis=2)
        first = np.floor(material.datasets[index].time / BLOCK_SECONDS) % 2 == 0
        first = np.repeat(first[:, None], seen.shape[1], axis=1)
        parts.append((hats[seen], derivatives[seen], residual[seen], first[seen]))
    hats, model, residual, first = (np.concatenate(part) for part in zip(*parts, strict=True))
    size = np.sqrt(np.mean(model**2, axis=0))
    bend = block_diag(*(_slope_changes(curve.knots) for curve in curves))
    return _Rows(hats, model[:, size > 0] / size[size > 0], residual, first, bend)


def _hat_functions(curves: Sequence[Curve], view: View) -> Floats:
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
