"""Base parameters: the fewest combinations of physical parameters that determine the torque.

M. Gautier, "Numerical calculation of the base inertial parameters of robots" (1991): QR of the regressor at random
states. A column that those before it span has no parameter of its own; its parameter is added to theirs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats, Ints

_DEPENDENT = 1e-8
"""Share of a column outside the span of earlier ones, below which it has no parameter of its own; rounding leaves
1e-12."""


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """b base parameters of k physical ones."""

    columns: Ints
    """(b,) the physical parameters that stand for a base parameter each."""
    combination: Floats
    """(b, k) base parameters per unit of the physical ones."""

    def sum_of(self, index: int, names: Sequence[str]) -> str:
        """Base parameter `index` as a sum of physical parameters, called by their `names` (k,)."""
        shares = self.combination[index]
        first = int(self.columns[index])
        others = [k for k in np.flatnonzero(shares).tolist() if k != first]
        terms = [f" {'-' if shares[k] < 0 else '+'} {_factor(abs(shares[k]))}{names[k]}" for k in others]
        return names[first] + "".join(terms)


def base_parameters(regressor: Floats) -> BaseParameters:
    """Return the base parameters of a `regressor` (r, k) at many random states, by Gram-Schmidt.

    Earlier columns are kept, so that the columns' order says which parameters name the combinations.
    """
    length = np.linalg.norm(regressor, axis=0)
    basis, kept = np.empty((len(regressor), 0)), []
    for column in np.flatnonzero(length > _DEPENDENT * length.max()):
        rest = regressor[:, column] / length[column]
        for _ in range(2):  # once is not orthogonal to the last digits
            rest = rest - basis @ (basis.T @ rest)
        if (size := np.linalg.norm(rest)) > _DEPENDENT:
            basis = np.column_stack([basis, rest / size])
            kept.append(int(column))
    combination: Floats = np.asarray(np.linalg.lstsq(regressor[:, kept], regressor, rcond=None)[0], np.float64)
    combination[np.abs(combination) < _DEPENDENT] = 0.0
    combination[:, kept] = np.eye(len(kept))
    return BaseParameters(np.array(kept, dtype=np.int64), combination)


def _factor(size: float) -> str:
    return "" if abs(size - 1) < _DEPENDENT else f"{size:.4g} "
