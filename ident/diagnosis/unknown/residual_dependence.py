"""Find the variables on which a residual depends, by curves over the motion.

For each joint, sums of curves over one variable (also in each direction of motion, and of the other joints' motion)
are fitted to its residual on the training rows, together with all parameters of the model. They are scored by the
share that they explain of what the model alone leaves on the test rows if it adapts to this joint. The simplest sum
close to the best is chosen. Its curves are then fitted together with the model: their values at the knots are
coefficients.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import get_args

import numpy as np

from ident.basics.statistics import nonzero
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE, Improvement
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.learned_curve import LearnedCurve, Variable, unknown_curve
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

KNOTS = 9
"""Number of knots of each curve."""
MIN_RELATIVE_SHARE = 0.85
"""A simpler sum of curves must explain this share of what the best one explains."""
_RIDGE = 1e-3
"""Penalty of a squared coefficient, relative to the mean square of its column: a knot may have hardly any rows."""


@dataclass(frozen=True)
class ResidualDependence:
    """Variables on which the residual of one joint depends."""

    curves: tuple[LearnedCurve, ...]
    """Their sum explains the residual; they have knots, but no values yet."""
    explained: float
    """Share of the mean square that the model leaves on the test rows of this joint."""

    @property
    def joint(self) -> int:
        """From 0."""
        return self.curves[0].joint - 1

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables, and of the other joints whose motion it is."""
        directed = ["velocity"] if any(curve.multiplier != "one" for curve in self.curves) else []
        others = [f"joint_{curve.variable_joint}" for curve in self.curves if curve.variable_joint != curve.joint]
        return self.curves[0].variable, *directed, *others


@dataclass(frozen=True, eq=False)
class NonparametricFit:
    """Learned curves and the improvement by them."""

    dependences: tuple[ResidualDependence, ...]
    """What the curves are over."""
    model: FittedModel
    """The model with the curves in addition: its last terms."""
    improvement: Improvement
    """On test rows."""

    @cached_property
    def curves(self) -> tuple[LearnedCurve, ...]:
        """The curves with their values."""
        curves = [curve for dependence in self.dependences for curve in dependence.curves]
        count = sum(len(curve.knots) for curve in curves)
        values = np.split(self.model.solution.x[-count:], np.cumsum([len(curve.knots) for curve in curves])[:-1])
        return tuple(replace(curve, values=tuple(each.tolist())) for curve, each in zip(curves, values, strict=True))


def find_dependences(
    split: SplitData, solution: Solution, residuals: Sequence[Floats], joints: Sequence[int]
) -> list[ResidualDependence]:
    """Dependences of the residuals (m, dof) of the given `joints`; joints that no curve explains are left out."""
    structure, x = solution.structure, solution.x
    inputs = [each.recorded_inputs(structure, x) for each in split.predictors]
    derivatives = [predictor.linearized(structure, x)[1] for predictor in split.predictors] if joints else []
    found = [
        _dependence(split, inputs, [d[:, joint] for d in derivatives], [r[:, joint] for r in residuals], joint)
        for joint in joints
    ]
    return [dependence for dependence in found if dependence]


def _dependence(
    split: SplitData,
    inputs: Sequence[EffectInputs],
    derivatives: Sequence[Floats],
    residuals: Sequence[Floats],
    joint: int,
) -> ResidualDependence | None:
    """The dependence of the residuals (m,) of a `joint`, from 0, whose model has `derivatives` (m, K)."""
    sums = list(_sums(joint + 1, len(split.torque_rms)))
    moving = [inputs[index] for index in split.train_indices]
    curves = {curve: _with_knots(curve, moving) for curve in chain.from_iterable(sums)}
    columns = [np.concatenate([curve.columns(each) for curve in curves.values()], axis=1) for each in inputs]
    rows = np.concatenate([np.column_stack(block) for block in zip(derivatives, columns, residuals, strict=True)])
    known = np.isfinite(rows).all(axis=1)
    train, test = (rows[known & np.concatenate(part)[:, joint]] for part in (split.train, split.test))
    if not len(train) or not len(test):
        return None
    size = nonzero(np.sqrt(np.mean(train**2, axis=0)))
    fitted, held_out = ((part / size).T @ (part / size) / len(part) for part in (train, test))
    of_model, *blocks = np.split(np.arange(len(size) - 1), derivatives[0].shape[1] + KNOTS * np.arange(len(curves)))
    of_curve = dict(zip(curves, blocks, strict=True))

    def remaining(curve_sum: Sequence[LearnedCurve]) -> float:
        """Mean square that the model with `curve_sum` leaves on the test rows."""
        entries = np.concatenate([of_model, *(of_curve[curve] for curve in curve_sum)])
        penalized = fitted[np.ix_(entries, entries)] + _RIDGE * np.eye(len(entries))
        weights = np.append(-np.linalg.solve(penalized, fitted[entries, -1]), 1.0)
        entries = np.append(entries, -1)
        return float(weights @ held_out[np.ix_(entries, entries)] @ weights)

    alone = remaining(())
    candidates = [
        ResidualDependence(tuple(curves[curve] for curve in each), 1 - remaining(each) / alone) for each in sums
    ]
    best = max(candidate.explained for candidate in candidates)
    enough = [candidate for candidate in candidates if candidate.explained >= MIN_RELATIVE_SHARE * best]
    if best < MIN_SHARE:
        return None
    # Rounded: without weight, the load is the acceleration times an inertia, and the first of both is said.
    return min(enough, key=lambda candidate: (len(candidate.variables), -round(candidate.explained, 2)))


def _sums(joint: int, dof: int) -> Iterator[tuple[LearnedCurve, ...]]:
    """Sums of curves to try for a `joint`, from 1, without knots."""
    own = [LearnedCurve(joint, variable, joint) for variable in get_args(Variable)]
    yield from ((curve,) for curve in own)
    yield from ((replace(curve, multiplier="direction"),) for curve in own if curve.variable != "velocity")
    yield (LearnedCurve(joint, "position", joint, "velocity"),)
    for curve in own[:3]:  # load and time are no motion
        others = [replace(curve, variable_joint=other) for other in range(1, dof + 1) if other != joint]
        # What acts between joints acts on what the joint itself does, too, whatever of that an effect imitates.
        yield from ((curve, other) for other in others)
        if len(others) > 1:
            yield (curve, *others)


def _with_knots(curve: LearnedCurve, inputs: Sequence[EffectInputs]) -> LearnedCurve:
    """The `curve` with knots between which equally many of the visited values lie."""
    visited = np.concatenate([curve.variable_values(each) for each in inputs])
    knots: Floats = np.nanquantile(visited, np.linspace(0.0, 1.0, KNOTS))
    return replace(curve, knots=tuple(knots.tolist()))


def fit_curves(final: FittedModel, dependences: Sequence[ResidualDependence]) -> NonparametricFit:
    """Fit the curves of the `dependences` together with all parameters of the model `final`."""
    structure, x = final.solution.structure, final.solution.x
    for dependence in dependences:
        for curve in dependence.curves:
            structure = structure.with_term(Term("learned_curve", unknown_curve(curve), (dependence.joint,)))
    zeros = np.zeros(len(structure.parameters) - len(x))
    model = FittedModel(final.split, final.split.fit(structure, np.concatenate([x, zeros])))
    return NonparametricFit(tuple(dependences), model, model.improvement_over(final))
