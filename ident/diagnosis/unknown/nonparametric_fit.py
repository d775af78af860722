"""Fit learned curves to an unexplained residual: penalized piecewise linear functions, validated on test rows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Blocks, Improvement
from ident.diagnosis.split.split_data import SplitData, rms
from ident.diagnosis.unknown.normal_equations import NormalEquations
from ident.diagnosis.unknown.residual_dependence import ResidualDependence
from ident.diagnosis.unknown.unexplained_residual import MIN_JOINT_RATIO, estimate_unexplained
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.learned_curve import LearnedCurve, hat_functions, learned_effect
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
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

    curves: tuple[LearnedCurve, ...]
    dependences: tuple[ResidualDependence, ...]
    """The variables of the curves."""
    model: FittedModel
    """The final model with the curves."""
    improvement: Improvement
    """On test rows."""

    @property
    def supported(self) -> bool:
        """Whether the test rows support the curves."""
        return self.improvement.is_supported

    @property
    def described(self) -> tuple[ResidualDependence, ...]:
        """The dependences that are stated: without those of minor joints."""
        return tuple(dependence for dependence in self.dependences if not dependence.minor)

    def with_explained_of(self, final: FittedModel) -> "NonparametricFit":
        """The same fit; its dependences state the share of the residual of the `final` model that it explains."""
        test = final.split.test
        before, after = (rms(model.residuals, test) for model in (final, self.model))
        explained = 1 - (after / np.maximum(before, _TINY)) ** 2
        dependences = [replace(each, explained=float(explained[each.joint])) for each in self.dependences]
        return replace(self, dependences=tuple(dependences))

    def within_knots(self) -> list[Bools]:
        """(m,) rows of each recording in which the variable of every curve is in the range of its knots."""
        split, rows = self.model.split, []
        for recording, computed in zip(split.recordings, self.model.computed, strict=True):
            inside = np.ones(len(recording.time), bool)
            for curve in self.curves:
                signal = recording.time
                if curve.variable != "time":
                    signals = computed if curve.variable == "load" else getattr(recording.motion, curve.variable)
                    signal = signals[:, curve.variable_joint - 1]
                inside &= (curve.knots[0] <= signal) & (signal <= curve.knots[-1])
            rows.append(inside)
        return rows


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

    @cached_property
    def halves(self) -> tuple[NormalEquations, NormalEquations]:
        """The two halves of the cross-validation."""
        first, second = (
            NormalEquations.of(np.concatenate([self.regressor[rows], self.hats[rows]], axis=1), self.residual[rows])
            for rows in (self.first_half, ~self.first_half)
        )
        return first, second

    def penalty(self, smoothness: float) -> Floats:
        """(c, c) quadratic penalty per row on the model's parameters and on the values at the knots."""
        # The mean over all rows: knots that one half never visits must still be penalized.
        level = float(np.mean(self.hats**2))
        penalty = np.diag(
            np.r_[np.full(self.regressor.shape[1], _TINY), np.full(self.hats.shape[1], _SHRUNK * level)]
        )
        block = slice(self.regressor.shape[1], None)
        penalty[block, block] += smoothness * level * self.slope_changes.T @ self.slope_changes
        return penalty

    def cross_validation_error(self, smoothness: float) -> float:
        """Sum of squares of each half, predicted from the other half."""
        (first, second), penalty = self.halves, self.penalty(smoothness)
        return second.remaining(first.solve(penalty)) + first.remaining(second.solve(penalty))


def fit_curves(final: FittedModel) -> NonparametricFit | None:
    """Fit curves to the residual of the `final` model; None if it depends on no variable of a curve.

    One joint is added at a time: first those that change with time, then the one with the largest unexplained
    residual. The residuals of the other joints are meaningful only after that.
    """
    used: list[ResidualDependence] = []
    fit: NonparametricFit | None = None
    largest = 0.0
    for _ in range(final.residuals[0].shape[1]):
        unexplained = estimate_unexplained(fit.model if fit else final)
        share = unexplained.rms / final.split.torque_rms
        largest = max(largest, float(share.max()))
        candidates = [
            dependence
            for dependence in unexplained.dependences
            if dependence.joint not in {present.joint for present in used}
        ]
        if not candidates:
            break
        best = max(candidates, key=lambda dependence: ("time" in dependence.variables, share[dependence.joint]))
        is_minor = "time" not in best.variables and bool(share[best.joint] < MIN_JOINT_RATIO * largest)
        used.append(replace(best, minor=is_minor))
        fit = fit_curves_over(final, used)
    return fit


def fit_curves_over(final: FittedModel, dependences: Sequence[ResidualDependence]) -> NonparametricFit:
    """Fit curves over the variables of the `dependences` to the residual of the `final` model."""
    empty = [curve for dependence in dependences for curve in _empty_curves(dependence)]
    curves = _fit_values(final.split, final.solution, empty)
    model = _fit_with_curves(final, curves)
    blocks = Blocks.of(final.split, final.residuals, model.residuals, final.noise_floor.rms, final.split.test)
    improvement = blocks.improvement()
    return NonparametricFit(tuple(curves), tuple(dependences), model, improvement)


def _fit_with_curves(final: FittedModel, curves: Sequence[LearnedCurve]) -> FittedModel:
    """Refit the model `final` together with `curves`."""
    joints = tuple(sorted({curve.joint - 1 for curve in curves}))
    structure = final.solution.structure.with_term(Term("learned_curve", learned_effect(curves), joints))
    start = np.concatenate([final.solution.x, np.ones(len(joints))])
    return FittedModel(final.split, final.split.fit(structure, start))


def _empty_curves(dependence: ResidualDependence) -> list[LearnedCurve]:
    """Curves without knots over the variables of `dependence`."""
    return [
        LearnedCurve(
            dependence.joint + 1, curve_input.variable, curve_input.joint + 1, curve_input.multiplier, (), ()
        )
        for curve_input in dependence.inputs
    ]


def _fit_values(split: SplitData, solution: Solution, empty: Sequence[LearnedCurve]) -> list[LearnedCurve]:
    """Fit all curves together while the model's own parameters adapt."""
    all_inputs = [split.predictors[i].effect_inputs(solution.structure, solution.x) for i in split.train_indices]
    curves = [replace(curve, knots=_knots(curve, all_inputs)) for curve in empty]
    rows = _rows(split, solution, all_inputs, curves)
    smoothness = min(SMOOTHNESS, key=rows.cross_validation_error)
    first, second = rows.halves
    values = (first + second).solve(rows.penalty(smoothness))[rows.regressor.shape[1] :].reshape(-1, KNOTS)
    return [
        replace(curve, values=tuple(map(float, knot_values)))
        for curve, knot_values in zip(curves, values, strict=True)
    ]


def _knots(curve: LearnedCurve, all_inputs: Sequence[EffectInputs]) -> tuple[float, ...]:
    """Knots over the visited range, denser where more rows are."""
    signal = np.concatenate([curve.variable_values(inputs) for inputs in all_inputs])
    share = np.linspace(0.0, 1.0, KNOTS)
    quantiles = np.nanquantile(signal, share)
    knots: Floats = (quantiles + np.linspace(quantiles[0], quantiles[-1], KNOTS)) / 2
    return tuple(knots.tolist())


def _slope_changes(knots: Sequence[float]) -> Floats:
    """(KNOTS - 2, KNOTS) change of slope at each inner knot, in units of the mean distance of knots."""
    distance = np.diff(knots) / np.mean(np.diff(knots))
    slope = np.diff(np.eye(KNOTS), axis=0) / distance[:, None]
    change: Floats = np.diff(slope, axis=0)
    return change


def _rows(
    split: SplitData, solution: Solution, all_inputs: Sequence[EffectInputs], curves: Sequence[LearnedCurve]
) -> _Rows:
    from scipy.linalg import block_diag

    blocks = []
    pairs = zip(split.train_indices, all_inputs, solution.derivatives, solution.residuals, strict=True)
    for index, inputs, derivatives, residual in pairs:
        hats = split.predictors[index].prepared.condition(_columns(curves, inputs))
        train = split.train[index] & np.isfinite(residual)
        train &= np.isfinite(hats).all(axis=2) & np.isfinite(derivatives).all(axis=2)
        first_half = np.floor(split.recordings[index].time / BLOCK_SECONDS) % 2 == 0
        first_half = np.repeat(first_half[:, None], train.shape[1], axis=1)
        blocks.append((hats[train], derivatives[train], residual[train], first_half[train]))
    hats, regressor, residual, first_half = (np.concatenate(block) for block in zip(*blocks, strict=True))
    size = np.sqrt(np.mean(regressor**2, axis=0))
    slope_changes = block_diag(*(_slope_changes(curve.knots) for curve in curves))
    return _Rows(hats, regressor[:, size > 0] / size[size > 0], residual, first_half, slope_changes)


def _columns(curves: Sequence[LearnedCurve], inputs: EffectInputs) -> Floats:
    """(n, dof, curves * KNOTS) torque per unit of the value at each knot."""
    n, dof = inputs.motion.velocity.shape
    hats = np.zeros((n, dof, len(curves), KNOTS))
    for number, curve in enumerate(curves):
        signal = curve.variable_values(inputs)
        weight = np.where(np.isfinite(signal), curve.factor(inputs), np.nan)
        hats[:, curve.joint - 1, number] = hat_functions(signal, curve.knots) * weight[:, None]
    return hats.reshape(n, dof, -1)
