"""The confidence level of all intervals with its quantiles, the guard of quotients, and least squares."""

import numpy as np

from recordings.recording import Floats

LEVEL = 0.95
"""Confidence level of all intervals."""
NORMAL = 1.959963984540054
"""Half the width of an interval of this level, in standard errors that are known."""
TINY = 1e-150
"""In place of a divisor of zero; its square is a number, too."""


def nonzero(sizes: Floats) -> Floats:
    """The `sizes` as divisors: 1 in place of each zero, where what is divided is zero as well."""
    return np.where(sizes == 0, 1.0, sizes)


def half_width(freedom: Floats) -> Floats:
    """Half the width of an interval of `LEVEL`, in standard errors with this `freedom`, from Student's t."""
    from scipy.special import stdtrit  # takes time to import

    return np.asarray(stdtrit(freedom, (1 + LEVEL) / 2), np.float64)


def least_squares(matrix: Floats, targets: Floats) -> Floats:
    """(c, ...) coefficients of the columns of `matrix` (n, c) for the `targets` (n, ...), by the normal equations.

    Columns may be of any size, and those that others reproduce may be among them.
    """
    return solve_normal(matrix.T @ matrix, matrix.T @ targets)


def solve_normal(gram: Floats, products: Floats) -> Floats:
    """(c, ...) solution of the normal equations `gram` (c, c) . x = `products` (c, ...), as `least_squares`."""
    size = nonzero(np.sqrt(np.diag(gram)))
    scaled = np.linalg.lstsq(gram / np.outer(size, size), (products.T / size).T, rcond=1e-12)[0]
    return np.asarray((scaled.T / size).T, np.float64)
