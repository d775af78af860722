"""The exact minimum of objective (33), with a certified lower bound.

(33) is a sum of absolute values of residuals that are linear in the parameters: a linear program. Its dual is a lower
bound: for any y with |y_i| <= 1 and any parameters x in the search region,

    sum |b - A x|  >=  y'(b - A x)  >=  b'y - sum_j max(c_j lowest_j, c_j highest_j),   c = A'y,

because |r| >= y r, and a linear function attains its maximum in a corner of the region. The bound holds for any y and
equals the minimum at the dual optimum.
"""

import math
from dataclasses import dataclass

import numpy as np

from ident.estimation import lad_interior_point
from recordings.recording import Floats

GAP = 1e-12
"""Tolerance of the relative duality gap."""
PATIENCE = 5
"""Steps without improvement after which only round-off is assumed to remain."""
NEGLIGIBLE = 1e-9
"""Share of the torque below which a residual is not used as a unit."""

_ROUNDING = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, eq=False)
class Certificate:
    """The minimum of (33) within a search region lies between `lower_bound` and `objective`."""

    parameters: Floats
    """(k,) minimiser, with the value `objective`."""
    objective: float
    """[N m]"""
    lower_bound: float
    """[N m] lower bound of the objective within the search region."""
    unit: float
    """Reference of a relative excess [N m]: the bound, or a negligible share of the torque if that is larger."""

    def excess(self, objective: float) -> float:
        """Upper limit of the relative excess of `objective` [N m] over the minimum; never negative."""
        return max(0.0, (objective - self.lower_bound) / self.unit)


def certify(regressor: Floats, torque: Floats, bounds: Floats) -> Certificate:
    """Minimise (33) for torque (m,) [N m], regressor (m, k), bounds (k, 2) [lowest, highest], with a certificate."""
    best, best_gap, patience = None, np.inf, PATIENCE
    for parameters, y in lad_interior_point.iterates(regressor, torque, bounds):
        objective = float(np.abs(torque - regressor @ parameters).sum())
        gap = objective - float(torque @ y - _corner(regressor.T @ y, bounds).sum())
        if best is None or gap < best_gap:
            best, best_gap, patience = (parameters, y), gap, PATIENCE
        else:
            patience -= 1
        if best_gap <= GAP * objective or not patience:
            break
    assert best is not None  # the first iterate is the starting point
    return _certify(regressor, torque, bounds, *best)


def _certify(regressor: Floats, torque: Floats, bounds: Floats, parameters: Floats, y: Floats) -> Certificate:
    """Compute the bound with exact summation, less an upper limit of the rounding errors of the products."""
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
    """Maximum (k,) of slope (k,) times parameter over the bounds (k, 2)."""
    return np.maximum(slope * bounds[:, 0], slope * bounds[:, 1])
