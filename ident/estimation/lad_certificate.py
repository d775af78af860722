"""The exact minimum of objective (33), with the proof that nothing lies below it.

(33) is a sum of absolute values of residuals that are linear in the parameters: a linear program. Its dual bounds it
from below: for any y with |y_i| <= 1, and any parameters x in the search region,

    sum |b - A x|  >=  y'(b - A x)  >=  b'y - sum_j max(c_j lowest_j, c_j highest_j),   c = A'y,

because |r| >= y r, and no corner of the region is worse than the worst. So the bound holds whatever y is; it meets
the minimum where y is the dual optimum.
"""

import math
from dataclasses import dataclass

import numpy as np

from ident.estimation import lad_interior_point
from recordings.recording import Floats

GAP = 1e-12
"""Relative distance between minimum and bound that is aimed at."""
PATIENCE = 5
"""Steps without any gain after which round-off is taken to be all that is left."""
NEGLIGIBLE = 1e-9
"""Share of the torque. A residual below it is nothing to measure in."""

_ROUNDING = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Certificate:
    """The minimum of (33) within a search region lies between `lower_bound` and `objective`."""

    parameters: Floats
    """(k,) where `objective` is reached."""
    objective: float
    """[N m]"""
    lower_bound: float
    """[N m]; nothing in the search region has a lower objective."""
    unit: float
    """What an excess is relative to [N m]: the bound, or a negligible share of the torque where that is larger."""

    def excess(self, objective: float) -> float:
        """How far at most `objective` [N m] lies above the minimum, relative; not below 0, as round-off would."""
        return max(0.0, (objective - self.lower_bound) / self.unit)


def certify(regressor: Floats, torque: Floats, bounds: Floats) -> Certificate:
    """Minimise (33) for torque (m,) [N m], regressor (m, k), bounds (k, 2) [lowest, highest], and prove it."""
    best, gap, patience = None, np.inf, PATIENCE
    for parameters, y in lad_interior_point.iterates(regressor, torque, bounds):
        objective = float(np.abs(torque - regressor @ parameters).sum())
        found = objective - float(torque @ y - _corner(regressor.T @ y, bounds).sum())
        if best is None or found < gap:
            best, gap, patience = (parameters, y), found, PATIENCE
        else:
            patience -= 1
        if gap <= GAP * objective or not patience:
            break
    assert best is not None  # the first iterate is the starting point
    return _prove(regressor, torque, bounds, *best)


def _prove(regressor: Floats, torque: Floats, bounds: Floats, parameters: Floats, y: Floats) -> Certificate:
    """The bound in exact sums of products that are rounded once each, less the most that this can have added."""
    slope = np.array([math.fsum(column * y) for column in regressor.T])
    corner = _corner(slope, bounds)
    rounding = _ROUNDING * (
        np.abs(torque).sum()
        + np.abs(corner).sum()
        + (np.abs(regressor).sum(axis=0) + np.abs(slope)) @ np.abs(bounds).max(axis=1)
    )
    lower = max(0.0, math.fsum(torque * y) - math.fsum(corner) - float(rounding))
    objective = math.fsum(np.abs(torque - regressor @ parameters))
    unit = max(lower, NEGLIGIBLE * float(np.abs(torque).sum())) or 1.0
    return Certificate(parameters, objective, lower, unit)


def _corner(slope: Floats, bounds: Floats) -> Floats:
    """(k,) the most that parameters within bounds (k, 2) can make of slope (k,) times parameter."""
    most: Floats = np.maximum(slope * bounds[:, 0], slope * bounds[:, 1])
    return most
