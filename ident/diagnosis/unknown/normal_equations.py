"""Normal equations of a regression: many models of selected columns are solved and judged without its rows."""

from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats, Ints


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Sums over the rows of a regression with c columns."""

    gram: Floats
    """(c, c)"""
    moment: Floats
    """(c,)"""
    square: float
    """Sum of squares of the residual."""
    count: int
    """Number of rows."""

    @classmethod
    def of(cls, columns: Floats, residual: Floats) -> "NormalEquations":
        """Those of a `residual` (r,) for `columns` (r, c)."""
        return cls(columns.T @ columns, columns.T @ residual, float(residual @ residual), len(residual))

    def __add__(self, other: "NormalEquations") -> "NormalEquations":
        """Those of the rows of both."""
        return NormalEquations(
            self.gram + other.gram, self.moment + other.moment, self.square + other.square, self.count + other.count
        )

    def of_columns(self, entries: Ints) -> "NormalEquations":
        """Those of the columns `entries` (e,) alone."""
        return NormalEquations(self.gram[np.ix_(entries, entries)], self.moment[entries], self.square, self.count)

    def solve(self, penalty: Floats) -> Floats:
        """(c,) coefficients with a quadratic `penalty` (c, c) per row; of least norm where not determined."""
        matrix: Floats = self.gram + max(self.count, 1) * penalty
        coefficients: Floats = np.linalg.lstsq(matrix, self.moment, rcond=None)[0].astype(np.float64)
        return coefficients

    def remaining(self, coefficients: Floats) -> float:
        """Sum of squares of the residual with `coefficients` (c,)."""
        return self.square - float((2 * self.moment - self.gram @ coefficients) @ coefficients)
