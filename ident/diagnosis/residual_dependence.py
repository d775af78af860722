"""What a remainder depends on that no effect of the library explains: smooth curves of the motion, tried in turn.

Joint by joint, curves of one variable (and of position in each direction of motion, and of the other joints' motion)
are fitted to what the last model leaves, together with all of the model's parameters, on rows that fits may see, and
judged by what they explain of the rows held out. The simplest that explains nearly as much as the best is named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.diagnosis.split_data import SplitData
from ident.dynamics.effects.learned_curve import Times, Variable
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Bools, Floats

KNOTS = 8
"""Pieces of a curve, each with as many samples as the others."""
MIN_RELATIVE_SHARE = 0.85
"""Share of what the best curve explains that a simpler one must reach."""
MIN_EXPLAINED = 0.2
"""Share of the remainder that a curve must explain on held-out rows to be named at all."""
_RIDGE = 1e-3
"""Of the mean square of a column; keeps pieces that were hardly visited from swinging."""


@dataclass(frozen=True)
class CurveInput:
    """What a curve is over."""

    variable: Variable
    joint: int
    """Whose, from 0."""
    times: Times = "one"
    """What the curve's values are multiplied with."""


@dataclass(frozen=True)
class Dependence:
    """Of the remainder of one joint."""

    joint: int
    """From 0."""
    inputs: tuple[CurveInput, ...]
    """A sum of a curve over each."""
    variables: tuple[str, ...]
    explained: float
    """Share of its mean square on held-out rows."""


@dataclass(frozen=True, eq=False)
class _Rows:
    """All recordings, one after the other."""

    residual: Floats
    """(m, dof)"""
    regressor: Floats
    """(m, dof, K) of the model."""
    seen: Bools
    held: Bools
    """(m, dof)"""
    signals: dict[Variable, Floats]
    """(m, dof) by variable."""
    factors: dict[Times, Floats]
    """(m, dof)"""


def find_dependences(
    material: SplitData, solution: Solution, residuals: Sequence[Floats], joints: Sequence[int]
) -> list[Dependence]:
    """What the residuals (m, dof) of `joints` depend on; nothing where no curve explains any of it."""
    rows = _rows(material, solution, residuals)
    return [found for joint in joints if (found := _of(rows, joint))]


def _rows(material: SplitData, solution: Solution, residuals: Sequence[Floats]) -> _Rows:
    datasets = material.datasets
    derivatives = [one.linearised(solution.composition, solution.x)[1] for one in material.predictors]
    computed = [data.torque - left for data, left in zip(datasets, residuals, strict=True)]
    dof = residuals[0].shape[1]
    signals: dict[Variable, list[Floats]] = {
        "position": [data.motion.position for data in datasets],
        "velocity": [data.motion.velocity for data in datasets],
        "acceleration": [data.motion.acceleration for data in datasets],
        "load": computed,
        "time": [np.repeat(data.time[:, None], dof, axis=1) for data in datasets],
    }
    joined = {name: np.concatenate(parts) for name, parts in signals.items()}
    regressor, residual = np.concatenate(derivatives), np.concatenate(residuals)
    everything: Bools = np.all([np.isfinite(values).all(axis=1) for values in joined.values()], axis=0)
    known: Bools = np.isfinite(residual) & np.isfinite(regressor).all(axis=2) & everything[:, None]
    seen, held = (np.concatenate(part) & known for part in (material.train, material.test))
    direction = np.concatenate([data.motion.direction for data in datasets])
    factors: dict[Times, Floats] = {
        "one": np.ones_like(direction),
        "direction": np.nan_to_num(direction),
        "velocity": np.nan_to_num(joined["velocity"]),
    }
    return _Rows(residual, regressor, seen, held, joined, factors)


def _of(rows: _Rows, joint: int) -> Dependence | None:
    tried = [
        (sources, _explained(rows, joint, _columns(rows, joint, sources))) for sources in _candidates(rows, joint)
    ]
    best = max(share for _, share in tried)
    if best < MIN_EXPLAINED:
        return None
    enough = [one for one in tried if one[1] >= MIN_RELATIVE_SHARE * best]
    sources, share = min(enough, key=lambda one: (len(_variables(joint, one[0])), -one[1]))
    return Dependence(joint, sources, _variables(joint, sources), share)


def _candidates(rows: _Rows, joint: int) -> Iterator[tuple[CurveInput, ...]]:
    """What sums of curves may be over."""
    for name in rows.signals:
        yield (CurveInput(name, joint),)
    for name in rows.signals:
        if name != "velocity":
            yield (CurveInput(name, joint, "direction"),)
    yield (CurveInput("position", joint, "velocity"),)
    others = [other for other in range(rows.residual.shape[1]) if other != joint]
    moving: tuple[Variable, ...] = ("position", "velocity", "acceleration")
    for name in moving:
        yield from ((CurveInput(name, other),) for other in others)
        if len(others) > 1:
            yield tuple(CurveInput(name, other) for other in others)


def _variables(joint: int, sources: Sequence[CurveInput]) -> tuple[str, ...]:
    """As a diagnosis names them."""
    turned = ["velocity"] if any(one.times != "one" for one in sources) else []
    others = [f"joint_{one.joint + 1}" for one in sources if one.joint != joint]
    return sources[0].variable, *turned, *others


def _columns(rows: _Rows, joint: int, sources: Sequence[CurveInput]) -> Floats:
    """(m, c) of a curve over each of the `sources`."""
    curves = [
        _curve(rows.signals[one.variable][:, one.joint], rows.seen[:, joint])
        * rows.factors[one.times][:, joint, None]
        for one in sources
    ]
    return np.concatenate(curves, axis=1)


def _curve(x: Floats, seen: Bools) -> Floats:
    """(m, KNOTS + 1) piecewise linear functions of `x` (m,) that add up to one."""
    inside = x[seen]
    knots = np.unique(np.quantile(inside, np.linspace(0, 1, KNOTS + 1)))
    place = np.interp(np.nan_to_num(x), knots, np.arange(len(knots)))
    hats: Floats = np.maximum(1 - np.abs(place[:, None] - np.arange(len(knots))), 0.0)
    return hats


def _explained(rows: _Rows, joint: int, columns: Floats) -> float:
    """Share of the held-out mean square of a joint that curves with these `columns` (m, c) explain.

    The model's own parameters move along, but only as far as this joint asks for it.
    """
    seen, held = rows.seen[:, joint], rows.held[:, joint]
    own = rows.regressor[:, joint]
    own = own[:, np.abs(own[seen]).sum(axis=0) > 0]
    both = np.concatenate([own / np.sqrt(np.mean(own[seen] ** 2, axis=0)), columns], axis=1)
    size = np.concatenate([np.zeros(own.shape[1]) + 1e-6, np.full(columns.shape[1], _RIDGE)])
    matrix = both[seen].T @ both[seen] + np.diag(size * len(both[seen]) * 0.1)
    coefficients = np.linalg.solve(matrix, both[seen].T @ rows.residual[seen, joint])
    left = rows.residual[held, joint] - both[held] @ coefficients
    before = float(np.mean(rows.residual[held, joint] ** 2))
    return 1 - float(np.mean(left**2)) / before if before else 0.0
