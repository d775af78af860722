"""Covariance and confidence intervals of parameters, for autocorrelated residuals.

The error of an estimate is a sum over all samples of influence times noise. For least squares with weights
w, the influence of the noise e is B^-1 w^2 x with B = sum w^2 x x' (x: a row of the regressor). For least absolute
deviations, objective (33), only the sign of e matters: it is B^-1 w x, with B = sum 2 f w x x' and the density f of e
at zero. The variance of that sum follows from the autocovariance of the noise, estimated by one of three methods:

- "stationary" (the default): the noise, divided by its standard deviation at each sample, is a stationary process.
  Its spectrum is estimated from the residuals of all joints; the regressor is known.
- "hac": Newey and West's estimator with Parzen's weights and Andrews' bandwidth, from products of influence and
  residual. It assumes less, but its own scatter is larger; Student's t accounts for it.
- "cycles": one repetition of the motion is one block. This is the limit of a bootstrap over repetitions. With C
  repetitions Student's t has C - 1 degrees of freedom, so few repetitions give wide intervals. The part of the
  residual that repeats with the motion does not count as noise here.

`benchmarks/intervals.py` measures how often the intervals hold the truth.
All intervals are conditional on the model and the geometry. The first two methods count model errors as noise.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.basics import slicing, statistics
from ident.basics.statistics import LEVEL as LEVEL
from ident.uncertainty import autocovariance
from recordings.errors import BadInput, told
from recordings.recording import Bools, Floats, Ints

IntervalMethod = Literal["stationary", "hac", "cycles"]
_KERNEL = 0.3
"""Width of the kernel of the density estimate, in standard deviations."""
_BLOCK = 2**15
"""Longest block of rows. Longer recordings are split, which bounds the memory of transforms."""


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive rows of one recording. Noise and influence of an invalid sample are zero."""

    regressor: Floats
    """(m, dof, k)."""
    factor: Floats
    """(m, dof) factor f: the influence of a sample's unit noise is B^-1 f x."""
    noise: Floats
    """(m, dof) unit noise, computed from the residual."""
    valid: Floats
    """(m, dof) 1 where there is a residual, else 0."""
    per_residual: Floats
    """(m, dof) unit noise per unit of residual; 0 if the noise is not proportional to the residual."""
    cycle: Ints
    """(m,) repetition of the motion, -1 outside of all; the numbers of different recordings differ."""

    def weighted(self, weight: Floats) -> Floats:
        """(m, dof, k) regressor times `weight` (m, dof), zero where there is no residual."""
        return np.where(self.valid[:, :, None] > 0, self.regressor * weight[:, :, None], 0.0)

    def normal_matrix(self) -> Floats:
        """(k, k) contribution to B of rows fitted by least squares: w^2 is factor times per_residual."""
        rows = self.weighted(np.sqrt(self.factor * self.per_residual)).reshape(-1, self.regressor.shape[2])
        return rows.T @ rows

    def influence(self, inverse: Floats) -> Floats:
        """(m, dof, k) influence of each sample's noise on the parameters, given B^-1 (k, k)."""
        return self.weighted(self.factor) @ inverse

    def scores(self, inverse: Floats) -> Floats:
        """(m, k) contribution of the noise of each row to the error of each parameter, given B^-1 (k, k)."""
        return np.einsum("mjk,mj->mk", self.influence(inverse), self.noise)

    def split(self) -> Iterator["Block"]:
        """Yield the same rows in blocks of limited length."""
        for first in range(0, len(self.noise), _BLOCK):
            yield slicing.along_time(self, slice(first, first + _BLOCK))


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariance of the errors of k parameters; NaN for parameters at a bound."""

    method: IntervalMethod
    covariance: Floats
    """(k, k) covariance of the parameters."""
    degrees_of_freedom: Floats
    """(k,) degrees of freedom of each variance."""

    @property
    def std(self) -> Floats:
        """(k,) standard errors."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """(k, k) correlation of the parameters' errors."""
        std = self.std
        with np.errstate(invalid="ignore", divide="ignore"):
            matrix: Floats = self.covariance / np.outer(std, std)
        return matrix

    def expanded(self, free: Bools) -> "Uncertainty":
        """Embed in a larger set of parameters (k,), of which these are the `free` ones; NaN for the others."""
        covariance, freedom = np.full((len(free), len(free)), np.nan), np.full(len(free), np.nan)
        covariance[np.ix_(free, free)] = self.covariance
        freedom[free] = self.degrees_of_freedom
        return Uncertainty(self.method, covariance, freedom)

    def half_width(self) -> Floats:
        """(k,) half widths of the 95 % intervals, from Student's t."""
        return statistics.half_width(self.degrees_of_freedom) * self.std

    def interval(
        self, parameters: Floats, gain_uncertainty: Floats | float = 0.0, propagated: Floats | float = 0.0
    ) -> Floats:
        """(k, 2) 95 % interval of each of the `parameters` (k,).

        gain_uncertainty: relative standard uncertainty of the torque gain, 0 where a parameter is not proportional to
            it; (k,), or one for all.
        propagated: (k,) mean squares of errors that are no noise.
        """
        others = statistics.NORMAL * np.sqrt((gain_uncertainty * parameters) ** 2 + propagated)
        width = np.hypot(self.half_width(), others)
        return np.stack([parameters - width, parameters + width], axis=1)


def least_squares(
    regressor: Floats, residual: Floats, std: Floats, cycle: Ints, weight: Floats | None = None
) -> tuple[Block, Floats]:
    """Rows of one recording fitted by least squares, and their contribution to B (k, k).

    regressor: (m, dof, k).
    residual: (m, dof); NaN where there is none.
    std: (m, dof) of the noise in the residual's unit, up to a common factor.
    cycle: (m,).
    weight: (m, dof) factor of the residual in the fit; 1 if None.
    """
    weight = np.ones_like(residual) if weight is None else weight
    valid = np.isfinite(residual)
    share = np.where(valid, 1 / std, 0.0)
    noise = np.where(valid, residual, 0.0) * share
    block = Block(regressor, weight**2 * std, noise, valid.astype(np.float64), share, cycle)
    return block, np.sum([piece.normal_matrix() for piece in block.split()], axis=0)


def least_absolute(regressor: Floats, residual: Floats, std: Floats, cycle: Ints) -> tuple[Block, Floats]:
    """Rows of one recording fitted by least absolute deviations, and their contribution to B; see `least_squares`."""
    valid = np.isfinite(residual)
    density = np.array([_density_at_zero(column[np.isfinite(column)]) for column in (residual / std).T])
    steepness = np.where(valid, 2 * density / std, 0.0)
    rows = np.where(valid[:, :, None], regressor, 0.0)
    bread = np.einsum("mjk,mj,mjl->kl", rows, steepness, rows, optimize=True)
    signs = np.where(valid, np.sign(np.nan_to_num(residual)), 0.0)
    zeros = np.zeros_like(std)
    return Block(regressor, zeros + 1, signs, valid.astype(np.float64), zeros, cycle), bread


def _density_at_zero(x: Floats) -> float:
    """Density at 0 of the distribution of `x` (n,), by a Gaussian kernel.

    The kernel's width does not shrink with n: a fit of k parameters makes k residuals exactly zero and pulls their
    autocorrelated neighbours towards zero, which must not dominate. For normal noise this lowers the density by 4 %.
    """
    spread = min(x.std(), float(np.subtract(*np.percentile(x, [75, 25]))) / 1.34)
    width = _KERNEL * spread
    if width == 0:
        return np.inf
    return float(np.mean(np.exp(-0.5 * (x / width) ** 2)) / (width * np.sqrt(2 * np.pi)))


def estimate(recordings: Sequence[tuple[Block, Floats]], method: IntervalMethod = "stationary") -> Uncertainty:
    """Uncertainty of parameters fitted to all `recordings` together; each is a result of `least_squares` or the like.

    Raises:
        BadInput: the method is "cycles", but there are fewer than two repetitions.
    """
    blocks = [piece for block, _ in recordings for piece in block.split()]
    inverse = np.linalg.inv(np.sum([bread for _, bread in recordings], axis=0))
    covariance, freedom = _METHODS[method](blocks, inverse)
    # With gaps of the joints at different places, no process may have the estimated autocovariances.
    if (np.diag(covariance) < 0).any():
        covariance, freedom = _hac(blocks, inverse)
    if method != "cycles":
        covariance = covariance / (1 - _absorbed_share(blocks, covariance))
    return Uncertainty(method, covariance, np.maximum(freedom, 1.0))


def _absorbed_share(blocks: Sequence[Block], covariance: Floats) -> float:
    """Share of the noise's energy that the fit absorbed, so that the residual lacks it."""
    absorbed, remaining = 0.0, 0.0
    for block in blocks:
        rows = block.weighted(block.per_residual)
        absorbed += float(np.einsum("mjk,kl,mjl->", rows, covariance, rows, optimize=True))
        remaining += float((block.noise**2).sum())
    return absorbed / (absorbed + remaining) if remaining else 0.0


def _stationary(blocks: Sequence[Block], inverse: Floats) -> tuple[Floats, Floats]:
    process = autocovariance.StationaryNoise.estimate(
        [block.noise for block in blocks], [block.valid for block in blocks]
    )
    return process.variance_of_sums(block.influence(inverse) for block in blocks)


def _hac(blocks: Sequence[Block], inverse: Floats) -> tuple[Floats, Floats]:
    scores = [block.scores(inverse) for block in blocks]
    return autocovariance.variance_of_sum(scores)


def _cycles(blocks: Sequence[Block], inverse: Floats) -> tuple[Floats, Floats]:
    number = np.concatenate([block.cycle for block in blocks])
    scores = np.concatenate([block.scores(inverse) for block in blocks])
    names = np.unique(number[number >= 0])
    if len(names) < 2:
        raise BadInput(
            f"intervals from repetitions need at least two of the motion, {len(names)} found; choose "
            + told("--intervals stationary", 'intervals="stationary"')
            + ", or record more cycles"
        )
    sums = np.stack([scores[number == name].sum(axis=0) for name in names])
    sums -= sums.mean(axis=0)
    count = len(names)
    return count / (count - 1) * sums.T @ sums, np.full(sums.shape[1], count - 1.0)


_METHODS: dict[IntervalMethod, Callable[[Sequence[Block], Floats], tuple[Floats, Floats]]] = {
    "stationary": _stationary,
    "hac": _hac,
    "cycles": _cycles,
}
