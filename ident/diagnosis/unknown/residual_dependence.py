"""Find the variables on which an unexplained residual depends, by smooth curves of the motion.

For each joint, curves of one variable (also of position in each direction of motion, and of the other joints' motion)
are fitted to the residual of the final model, together with all of its parameters, on the training rows. They are
scored by the share of the test residual that they explain. The simplest one close to the best is chosen.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.unknown.normal_equations import NormalEquations
from ident.dynamics.effects.learned_curve import Multiplier, Variable, hat_functions
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Bools, Floats, Ints

KNOTS = 8
"""Number of pieces of a curve, with the same number of samples each."""
MIN_RELATIVE_SHARE = 0.85
"""A simpler curve must explain this share of what the best one explains."""
MIN_EXPLAINED = 0.2
"""A curve must explain this share of the test residual."""
_RIDGE = 1e-4
"""Ridge penalty of a piece of a curve, per row; it regularizes pieces with few samples."""
_RIDGE_OF_MODEL = 1e-7
"""Ridge penalty of a parameter of the model, relative to the mean square of its column."""


@dataclass(frozen=True)
class CurveInput:
    """The variable of a curve."""

    variable: Variable
    joint: int
    """Joint of the variable, from 0."""
    multiplier: Multiplier = "one"
    """Factor by which the curve's values are multiplied."""


@dataclass(frozen=True)
class ResidualDependence:
    """Variables on which the residual of one joint depends."""

    joint: int
    """From 0."""
    inputs: tuple[CurveInput, ...]
    """The dependence is the sum of one curve over each input."""
    variables: tuple[str, ...]
    explained: float
    """Share of the mean square on test rows."""
    minor: bool = False
    """Whether the residual of this joint was small beside that of others when its curves were added: the curves of
    those may have left it, so it is explained but not described."""


@dataclass(frozen=True, eq=False)
class _Rows:
    """All recordings, one after the other."""

    residual: Floats
    """(m, dof)"""
    regressor: Floats
    """(m, dof, K) of the model."""
    train: Bools
    test: Bools
    """(m, dof)"""
    signals: dict[Variable, Floats]
    """(m, dof) by variable."""
    factors: dict[Multiplier, Floats]
    """(m, dof)"""


def find_dependences(
    split: SplitData, solution: Solution, residuals: Sequence[Floats], joints: Sequence[int]
) -> list[ResidualDependence]:
    """Dependences of the residuals (m, dof) of the given `joints`; joints that no curve explains are left out."""
    rows = _rows(split, solution, residuals)
    return [dependence for joint in joints if (dependence := _joint_dependence(rows, joint))]


def _rows(split: SplitData, solution: Solution, residuals: Sequence[Floats]) -> _Rows:
    recordings = split.recordings
    derivatives = [predictor.linearized(solution.structure, solution.x)[1] for predictor in split.predictors]
    computed = [data.torque - residual for data, residual in zip(recordings, residuals, strict=True)]
    dof = residuals[0].shape[1]
    signals: dict[Variable, list[Floats]] = {
        "position": [data.motion.position for data in recordings],
        "velocity": [data.motion.velocity for data in recordings],
        "acceleration": [data.motion.acceleration for data in recordings],
        "load": computed,
        "time": [np.repeat(data.time[:, None], dof, axis=1) for data in recordings],
    }
    joined = {name: np.concatenate(values) for name, values in signals.items()}
    regressor, residual = np.concatenate(derivatives), np.concatenate(residuals)
    finite: Bools = np.all([np.isfinite(values).all(axis=1) for values in joined.values()], axis=0)
    known: Bools = np.isfinite(residual) & np.isfinite(regressor).all(axis=2) & finite[:, None]
    train, test = (np.concatenate(rows) & known for rows in (split.train, split.test))
    direction = np.concatenate([data.motion.direction for data in recordings])
    factors: dict[Multiplier, Floats] = {
        "one": np.ones_like(direction),
        "direction": np.nan_to_num(direction),
        "velocity": np.nan_to_num(joined["velocity"]),
    }
    return _Rows(residual, regressor, train, test, joined, factors)


def _joint_dependence(rows: _Rows, joint: int) -> ResidualDependence | None:
    if not rows.train[:, joint].any() or not rows.test[:, joint].any():
        return None
    squares = _Squares(rows, joint)
    candidates = [(inputs, squares.explained_share(inputs)) for inputs in _input_candidates(rows, joint)]
    best = max(share for _, share in candidates)
    if best < MIN_EXPLAINED:
        return None
    enough = [candidate for candidate in candidates if candidate[1] >= MIN_RELATIVE_SHARE * best]
    inputs, share = min(enough, key=lambda candidate: (len(_variable_names(joint, candidate[0])), -candidate[1]))
    return ResidualDependence(joint, inputs, _variable_names(joint, inputs), share)


def _input_candidates(rows: _Rows, joint: int) -> Iterator[tuple[CurveInput, ...]]:
    """Inputs of the sums of curves to try."""
    for name in rows.signals:
        yield (CurveInput(name, joint),)
    for name in rows.signals:
        if name != "velocity":
            yield (CurveInput(name, joint, "direction"),)
    yield (CurveInput("position", joint, "velocity"),)
    others = [other_joint for other_joint in range(rows.residual.shape[1]) if other_joint != joint]
    variables: tuple[Variable, ...] = ("position", "velocity", "acceleration")
    for name in variables:
        yield from ((CurveInput(name, other_joint),) for other_joint in others)
        yield from ((CurveInput(name, joint), CurveInput(name, other_joint)) for other_joint in others)
        if len(others) > 1:
            yield tuple(CurveInput(name, other_joint) for other_joint in others)
            yield tuple(CurveInput(name, each) for each in (joint, *others))


def _variable_names(joint: int, inputs: Sequence[CurveInput]) -> tuple[str, ...]:
    """Names of the variables as they are reported."""
    factors = ["velocity"] if any(curve_input.multiplier != "one" for curve_input in inputs) else []
    others = [f"joint_{curve_input.joint + 1}" for curve_input in inputs if curve_input.joint != joint]
    return inputs[0].variable, *factors, *others


class _Squares:
    """Normal equations of the residual of a `joint`, for the model's parameters and all curves at once.

    Each sum of curves is a selection of their columns.
    """

    def __init__(self, rows: _Rows, joint: int) -> None:
        used = rows.train[:, joint] | rows.test[:, joint]
        train = rows.train[used, joint]
        regressor = rows.regressor[used, joint]
        size = np.sqrt(np.mean(regressor[train] ** 2, axis=0))
        columns = [regressor[:, size > 0] / size[size > 0]]
        self._entries: dict[CurveInput | None, Ints] = {None: np.arange(columns[0].shape[1])}
        for curve_input in dict.fromkeys(each for inputs in _input_candidates(rows, joint) for each in inputs):
            hats = _hats(rows.signals[curve_input.variable][used, curve_input.joint], train)
            first = sum(block.shape[1] for block in columns)
            self._entries[curve_input] = np.arange(first, first + hats.shape[1])
            columns.append(hats * rows.factors[curve_input.multiplier][used, joint, None])
        combined, residual = np.concatenate(columns, axis=1), rows.residual[used, joint]
        self._train, self._test = (
            NormalEquations.of(combined[selected], residual[selected]) for selected in (train, rows.test[used, joint])
        )

    def explained_share(self, inputs: Sequence[CurveInput]) -> float:
        """Share of the test mean square that one curve over each of the `inputs` explains.

        The model's parameters adapt, but only as far as this joint requires.
        """
        of_model, of_curves = self._entries[None], [self._entries[each] for each in inputs]
        entries = np.concatenate([of_model, *of_curves])
        ridge = np.where(np.arange(len(entries)) < len(of_model), _RIDGE_OF_MODEL, _RIDGE)
        coefficients = self._train.of_columns(entries).solve(np.diag(ridge))
        before = self._test.square
        return 1 - self._test.of_columns(entries).remaining(coefficients) / before if before else 0.0


def _hats(x: Floats, train: Bools) -> Floats:
    """(m, KNOTS + 1) hat functions of `x` (m,), with knots from the `train` rows."""
    return hat_functions(x, np.unique(np.quantile(x[train], np.linspace(0, 1, KNOTS + 1))))
