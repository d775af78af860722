"""Least absolute deviations inside a box, by a primal-dual interior point method.

Minimise sum |b - A x| over lowest <= x <= highest. Portnoy, Koenker, "The Gaussian hare and the Laplacian tortoise",
Statist. Sci. 12 (1997), with the predictor and corrector of Mehrotra, SIAM J. Optim. 2 (1992). The box enters as rows
that cost on one side only, and more there than leaving the box could gain.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats

_STAY_INSIDE = 0.99995
"""Share of the way to the nearest wall that a step may take."""


@dataclass
class _Point:
    """An iterate: rows r - X x = above - below, both positive, and dual values y between their walls."""

    x: Floats
    y: Floats
    above: Floats
    below: Floats


def iterates(regressor: Floats, torque: Floats, bounds: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Parameters (k,) within bounds (k, 2) and dual values (m,) within +-1, ever nearer to the optimal ones.

    They end where the arithmetic allows no further step; fifteen steps are usual.
    """
    m, k = regressor.shape
    size = np.abs(regressor).mean(axis=0)
    size[size == 0] = 1.0
    box = bounds * size[:, None]
    X = np.concatenate([regressor / size, np.eye(k), -np.eye(k)])
    r = np.concatenate([torque, box[:, 0], -box[:, 1]])
    # The absolute values of a column of X sum up to m, so 2 m is more than any slope of the objective.
    walls = np.repeat([[-1.0, 1.0], [0.0, 2.0 * m]], [m, 2 * k], axis=0)
    point = _start(X, r, m, np.clip(np.linalg.lstsq(X[:m], torque, rcond=None)[0], *box.T))
    moved = True
    while moved:
        yield np.clip(point.x / size, *bounds.T), np.clip(point.y[:m], -1.0, 1.0)
        with np.errstate(all="ignore"):
            moved = _advance(point, X, r, walls)


def _start(X: Floats, r: Floats, m: int, x: Floats) -> _Point:
    residual = r - X @ x
    spread = float(np.abs(residual[:m]).mean()) or 1.0
    y = np.repeat([0.0, 1.0], [m, len(r) - m])
    return _Point(x, y, np.maximum(residual, 0) + spread, np.maximum(-residual, 0) + spread)


def _advance(point: _Point, X: Floats, r: Floats, walls: Floats) -> bool:
    """Move `point` by one predictor and corrector; False where the result would not be finite."""
    low, high = point.y - walls[:, 0], walls[:, 1] - point.y
    residual = r - X @ point.x - point.above + point.below
    weight = 1 / (point.below / low + point.above / high)
    normal = X.T @ (weight[:, None] * X)
    try:
        inverse = np.linalg.pinv(normal, rcond=1e-15, hermitian=True)
    except np.linalg.LinAlgError:
        return False

    def step(low_target: Floats | float, high_target: Floats | float) -> _Point:
        """Newton's step towards the given products below * low and above * high."""
        to_low, to_high = low_target / low - point.below, high_target / high - point.above
        wanted = residual + to_low - to_high
        dx = inverse @ (X.T @ (weight * wanted + point.y))
        dy = weight * (wanted - X @ dx)
        return _Point(dx, dy, to_high + point.above / high * dy, to_low - point.below / low * dy)

    def reach(change: _Point) -> tuple[float, float]:
        """How much of a change the dual and the primal side can take."""
        return min(_share(low, change.y), _share(high, -change.y)), min(
            _share(point.above, change.above), _share(point.below, change.below)
        )

    ahead = step(0.0, 0.0)
    dual, primal = reach(ahead)
    now = low @ point.below + high @ point.above
    then = (low + dual * ahead.y) @ (point.below + primal * ahead.below)
    then += (high - dual * ahead.y) @ (point.above + primal * ahead.above)
    centre = (then / now) ** 3 * now / (2 * len(r))
    change = step(centre - ahead.y * ahead.below, centre + ahead.y * ahead.above)
    dual, primal = reach(change)
    if not np.isfinite([change.x.sum(), change.y.sum(), change.above.sum(), change.below.sum()]).all():
        return False
    point.x, point.y = point.x + primal * change.x, point.y + dual * change.y
    point.above, point.below = point.above + primal * change.above, point.below + primal * change.below
    return True


def _share(value: Floats, change: Floats) -> float:
    """How much of `change` the positive `value` can take and stay positive, at most 1."""
    falling = change < 0
    return min(1.0, _STAY_INSIDE * float(np.min(value[falling] / -change[falling], initial=np.inf)))
