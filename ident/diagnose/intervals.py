"""How well the parameters of a composition are known."""

import numpy as np

from ident import uncertainty
from ident.diagnose.material import Material
from ident.refine import Solution
from ident.uncertainty import Uncertainty
from recordings.recording import Bools, Floats

_DEPENDENT = 1e-7
"""Share of a column that others do not make up, below which nothing is known of its parameter."""


def intervals(material: Material, solution: Solution, gain_uncertainty: float) -> Floats:
    """(K, 2) 95 % intervals; NaN for what the data do not tell.

    gain_uncertainty: relative, of the torque gain; it counts for what is proportional to the torque.
    """
    linear = solution.composition.linear
    gain = np.where(linear, 1.96 * gain_uncertainty * np.abs(solution.x), 0.0)
    width = np.hypot(errors(material, solution).half_width(), gain)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def errors(material: Material, solution: Solution) -> Uncertainty:
    """Of the K parameters of `solution`; NaN for what the data do not tell."""
    free = np.array([entry.free for entry in solution.composition.named])
    regressor, _ = solution.rows()
    size = np.sqrt((regressor**2).sum(axis=0))
    told = free & (size > 0)
    told[told] = _independent(regressor[:, told] / size[told])
    parts = []
    pairs = zip(material.fitting, solution.residuals, solution.derivatives, solution.weights, strict=True)
    for index, residual, derivatives, weight in pairs:
        known = np.where(weight > 0, residual, np.nan)
        std = np.where(weight > 0, 1 / np.where(weight > 0, weight, 1.0), 1.0)
        repeat = material.datasets[index].repeat
        parts.append(uncertainty.least_squares(derivatives[:, :, told], known, std, repeat, weight))
    return uncertainty.of(parts).among(told)


def _independent(columns: Floats) -> Bools:
    """(k,) False for columns (r, k) that those before them make up."""
    diagonal = np.abs(np.diag(np.linalg.qr(columns, mode="r")))
    independent: Bools = diagonal > _DEPENDENT
    return independent
