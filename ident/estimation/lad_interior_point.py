"""Least absolute deviations inside a box, by a primal-dual interior point method.

Minimise sum |b - A x| over lowest <= x <= highest. Portnoy, Koenker, "The Gaussian hare and the Laplacian tortoise",
Statist. Sci. 12 (1997), with the predictor and corrector of Mehrotra, SIAM J. Optim. 2 (1992). The box is represented
by rows with a one-sided penalty, which exceeds any gain from leaving the box.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import nonzero
from recordings.recording import Floats

_STEP_FRACTION = 0.99995
"""Largest step, as a share of the distance to the nearest bound."""


@dataclass
class _Point:
    """An iterate: rows r - X x = above - below, both positive, and dual values y between their bounds."""

    x: Floats
    y: Floats
    above: Floats
    below: Floats


def iterates(regressor: Floats, torque: Floats, bounds: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Yield parameters (k,) within bounds (k, 2) and dual values (m,) within +-1 that converge to the optimum.

    The iteration ends when rounding errors permit no further step; fifteen steps are typical.
    """
    m, k = regressor.shape
    size = nonzero(np.abs(regressor).mean(axis=0))
    box = bounds * size[:, None]
    X = np.concatenate([regressor / size, np.eye(k), -np.eye(k)])
    r = np.concatenate([torque, box[:, 0], -box[:, 1]])
    # The absolute values of each column of X sum up to m, so 2 m exceeds any slope of the objective.
    dual_bounds = np.repeat([[-1.0, 1.0], [0.0, 2.0 * m]], [m, 2 * k], axis=0)
    point = _start(X, r, m, np.clip(np.linalg.lstsq(X[:m], torque, rcond=None)[0], *box.T))
    moved = True
    while moved:
        yield np.clip(point.x / size, *bounds.T), np.clip(point.y[:m], -1.0, 1.0)
        with np.errstate(all="ignore"):
            moved = _advance(point, X, r, dual_bounds)


def _start(X: Floats, r: Floats, m: int, x: Floats) -> _Point:
    residual = r - X @ x
    spread = float(np.abs(residual[:m]).mean()) or 1.0
    y = np.repeat([0.0, 1.0], [m, len(r) - m])
    return _Point(x, y, np.maximum(residual, 0) + spread, np.maximum(-residual, 0) + spread)


def _advance(point: _Point, X: Floats, r: Floats, dual_bounds: Floats) -> bool:
    """Advance `point` by a predictor-corrector step; return False if the result would not be finite."""
    low, high = point.y - dual_bounds[:, 0], dual_bounds[:, 1] - point.y
    residual = r - X @ point.x - point.above + point.below
    weight = 1 / (point.below / low + point.above / high)
    normal = X.T @ (weight[:, None] * X)
    try:
        inverse = np.linalg.pinv(normal, rcond=1e-15, hermitian=True)
    except np.linalg.LinAlgError:
        return False

    def step(low_target: Floats | float, high_target: Floats | float) -> _Point:
        """Newton step towards the target products below * low and above * high."""
        low_change, high_change = low_target / low - point.below, high_target / high - point.above
        target = residual + low_change - high_change
        dx = inverse @ (X.T @ (weight * target + point.y))
        dy = weight * (target - X @ dx)
        return _Point(dx, dy, high_change + point.above / high * dy, low_change - point.below / low * dy)

    def step_lengths(change: _Point) -> tuple[float, float]:
        """Longest dual and primal steps along `change`, as shares of it."""
        return min(_step_length(low, change.y), _step_length(high, -change.y)), min(
            _step_length(point.above, change.above), _step_length(point.below, change.below)
        )

    predictor = step(0.0, 0.0)
    dual, primal = step_lengths(predictor)
    gap = low @ point.below + high @ point.above
    predicted_gap = (low + dual * predictor.y) @ (point.below + primal * predictor.below)
    predicted_gap += (high - dual * predictor.y) @ (point.above + primal * predictor.above)
    centre = (predicted_gap / gap) ** 3 * gap / (2 * len(r))
    change = step(centre - predictor.y * predictor.below, centre + predictor.y * predictor.above)
    dual, primal = step_lengths(change)
    if not np.isfinite([change.x.sum(), change.y.sum(), change.above.sum(), change.below.sum()]).all():
        return False
    point.x, point.y = point.x + primal * change.x, point.y + dual * change.y
    point.above, point.below = point.above + primal * change.above, point.below + primal * change.below
    return True


def _step_length(value: Floats, change: Floats) -> float:
    """Largest share of `change`, at most 1, for which the positive `value` remains positive."""
    falling = change < 0
    return min(1.0, _STEP_FRACTION * float(np.min(value[falling] / -change[falling], initial=np.inf)))
