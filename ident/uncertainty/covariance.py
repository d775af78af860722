"""How well parameters are known: covariances and intervals that respect autocorrelated residuals.

An estimate deviates from the truth by a sum over all samples of influence times noise. For least squares with weights
w, the influence of the noise e is B^-1 w^2 x with B = sum w^2 x x' (x: a row of the regressor). For least absolute
deviations, objective (33), only the sign of e matters: it is B^-1 w x, with B = sum 2 f w x x' and the density f of e
at zero. The variance of that sum follows from the autocovariance of the noise, which is found in one of three ways:

- "stationary" (the default): the noise, divided by its standard deviation at each sample, is a stationary process.
  Its spectrum is estimated from the residuals of all joints; the regressor is known.
- "hac": Newey and West's estimator with Parzen's weights and Andrews' bandwidth, from products of influence and
  residual. It assumes less, and pays for it with a scatter of its own that Student's t has to make up for.
- "cycles": one repetition of the motion is one block. It is what a bootstrap over repetitions tends to, without its
  dice; with C of them Student's t has C - 1 degrees of freedom, so few repetitions give wide intervals. What repeats
  with the motion does not count as noise here.

`benchmarks/coverage.py` measures how often the intervals hold what they promise, and is why the first is the default.
All are about the noise, given the model and the geometry: they do not know what the model lacks, beyond counting what
it leaves as noise (the first two).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.uncertainty import autocovariance
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Ints

IntervalMethod = Literal["stationary", "hac", "cycles"]
LEVEL = 0.95
"""Of all intervals."""
_KERNEL = 0.3
"""Width of the kernel that estimates a density, in standard deviations."""
_BLOCK = 2**15
"""Longest block of rows; longer recordings are cut, which bounds the memory of transforms."""


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive rows of one recording. Noise and influence of a sample that is not known are zero."""

    regressor: Floats
    """(m, dof, k)."""
    factor: Floats
    """(m, dof) the influence of a sample's unit noise is B^-1 factor x."""
    noise: Floats
    """(m, dof) unit noise: what the residual says about it."""
    valid: Floats
    """(m, dof) 1 where there is a residual, else 0."""
    per_residual: Floats
    """(m, dof) unit noise per unit of residual; 0 if the one is not a multiple of the other."""
    cycle: Ints
    """(m,) repetition of the motion, -1 outside of all; no two blocks of different recordings share a number."""

    def weighted(self, weight: Floats) -> Floats:
        """The regressor (m, dof, k), times `weight` (m, dof), zero where there is no residual."""
        product: Floats = np.where(self.valid[:, :, None] > 0, self.regressor * weight[:, :, None], 0.0)
        return product

    def normal_matrix(self) -> Floats:
        """Their share of B (k, k) where they were fitted by least squares: w^2 is factor times per_residual."""
        rows = self.weighted(np.sqrt(self.factor * self.per_residual)).reshape(-1, self.regressor.shape[2])
        return rows.T @ rows

    def influence(self, inverse: Floats) -> Floats:
        """(m, dof, k), given B^-1 (k, k)."""
        scaled: Floats = self.weighted(self.factor) @ inverse
        return scaled

    def scores(self, inverse: Floats) -> Floats:
        """(m, k) what the noise of each instant adds to the error of each parameter, given B^-1 (k, k)."""
        added: Floats = np.einsum("mjk,mj->mk", self.influence(inverse), self.noise)
        return added

    def split(self) -> Iterator["Block"]:
        """The same rows in blocks that are not too long."""
        for first in range(0, len(self.noise), _BLOCK):
            part = slice(first, first + _BLOCK)
            names = ("regressor", "factor", "noise", "known", "per_residual", "cycle")
            yield Block(*(getattr(self, name)[part] for name in names))


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """What is known about the error of k parameters. NaN for one at a bound, which the bound decided."""

    method: IntervalMethod
    covariance: Floats
    """(k, k) of the parameters."""
    degrees_of_freedom: Floats
    """(k,) degrees of freedom of each variance."""

    @property
    def std(self) -> Floats:
        """(k,) standard errors."""
        error: Floats = np.sqrt(np.diag(self.covariance))
        return error

    @property
    def correlation(self) -> Floats:
        """(k, k) between the parameters' errors."""
        std = self.std
        with np.errstate(invalid="ignore", divide="ignore"):
            matrix: Floats = self.covariance / np.outer(std, std)
        return matrix

    def expanded(self, free: Bools) -> "Uncertainty":
        """The same as part of a larger set of parameters: these are the `free` ones (k,); NaN for the others."""
        covariance, freedom = np.full((len(free), len(free)), np.nan), np.full(len(free), np.nan)
        covariance[np.ix_(free, free)] = self.covariance
        freedom[free] = self.degrees_of_freedom
        return Uncertainty(self.method, covariance, freedom)

    def half_width(self) -> Floats:
        """(k,) of the 95 % interval, from Student's t."""
        from scipy.stats import t

        width: Floats = t.ppf((1 + LEVEL) / 2, self.degrees_of_freedom) * self.std
        return width

    def interval(self, parameters: Floats, gain_uncertainty: float = 0.0) -> Floats:
        """(k, 2) the 95 % interval of each of `parameters` (k,).

        `gain_uncertainty` is the relative standard uncertainty of the torque gain. All parameters are proportional to
        the gain, so that absolute values are no better known than it.
        """
        from scipy.stats import norm

        gain = norm.ppf((1 + LEVEL) / 2) * gain_uncertainty * np.abs(parameters)
        width = np.hypot(self.half_width(), gain)
        return np.stack([parameters - width, parameters + width], axis=1)


def least_squares(
    regressor: Floats, residual: Floats, std: Floats, cycle: Ints, weight: Floats | None = None
) -> tuple[Block, Floats]:
    """Rows of one recording fitted by least squares, and their share of B (k, k).

    regressor (m, dof, k); residual (m, dof), NaN where there is none; `std` (m, dof) in the residual's unit, up to a
    common factor; cycle (m,); weight (m, dof) with which the fit multiplied the residual, 1 if None.
    """
    weight = np.ones_like(residual) if weight is None else weight
    known = np.isfinite(residual)
    share = np.where(known, 1 / std, 0.0)
    noise = np.where(known, residual, 0.0) * share
    block = Block(regressor, weight**2 * std, noise, known.astype(np.float64), share, cycle)
    return block, np.sum([part.normal_matrix() for part in block.split()], axis=0)


def least_absolute(regressor: Floats, residual: Floats, std: Floats, cycle: Ints) -> tuple[Block, Floats]:
    """Rows of one recording fitted by least absolute deviations, and their share of B; as in `least_squares`."""
    known = np.isfinite(residual)
    density = np.array([_density_at_zero(column[np.isfinite(column)]) for column in (residual / std).T])
    steepness = np.where(known, 2 * density / std, 0.0)
    rows = np.where(known[:, :, None], regressor, 0.0)
    bread = np.einsum("mjk,mj,mjl->kl", rows, steepness, rows, optimize=True)
    signs = np.where(known, np.sign(np.nan_to_num(residual)), 0.0)
    none = np.zeros_like(std)
    return Block(regressor, none + 1, signs, known.astype(np.float64), none, cycle), bread


def _density_at_zero(x: Floats) -> float:
    """Density at 0 of the distribution of `x` (n,), by a Gaussian kernel.

    Its width does not shrink with n: a fit of k parameters drives k residuals to zero exactly, and with them their
    autocorrelated neighbours, which must not decide. For normal noise this lowers the density by 4 %.
    """
    spread = min(x.std(), float(np.subtract(*np.percentile(x, [75, 25]))) / 1.34)
    width = _KERNEL * spread
    if width == 0:
        return np.inf
    return float(np.mean(np.exp(-0.5 * (x / width) ** 2)) / (width * np.sqrt(2 * np.pi)))


def estimate(recordings: Sequence[tuple[Block, Floats]], method: IntervalMethod = "stationary") -> Uncertainty:
    """The uncertainty of parameters fitted to `parts` together, one for each recording (see `least_squares`).

    Raises:
        BadInput: "cycles" was asked for, but there are fewer than two repetitions.
    """
    blocks = [short for block, _ in recordings for short in block.split()]
    inverse = np.linalg.inv(np.sum([bread for _, bread in recordings], axis=0))
    covariance, freedom = _SOURCES[method](blocks, inverse)
    if method != "cycles":
        covariance = covariance / (1 - _taken_up(blocks, covariance))
    return Uncertainty(method, covariance, np.maximum(freedom, 1.0))


def _taken_up(blocks: Sequence[Block], covariance: Floats) -> float:
    """Share of the noise's energy that the fit took up into the parameters, so that the residual lacks it."""
    taken, left = 0.0, 0.0
    for block in blocks:
        rows = block.weighted(block.per_residual)
        taken += float(np.einsum("mjk,kl,mjl->", rows, covariance, rows, optimize=True))
        left += float((block.noise**2).sum())
    return taken / (taken + left) if left else 0.0


def _stationary(blocks: Sequence[Block], inverse: Floats) -> tuple[Floats, Floats]:
    process = autocovariance.StationaryNoise.estimate([block.noise for block in blocks], [block.valid for block in blocks])
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
            f"intervals from repetitions need at least two of the motion, {len(names)} found; choose --intervals "
            "stationary, or record more cycles"
        )
    sums = np.stack([scores[number == name].sum(axis=0) for name in names])
    sums -= sums.mean(axis=0)
    count = len(names)
    return count / (count - 1) * sums.T @ sums, np.full(sums.shape[1], count - 1.0)


_SOURCES: dict[IntervalMethod, Callable[[Sequence[Block], Floats], tuple[Floats, Floats]]] = {
    "stationary": _stationary,
    "hac": _hac,
    "cycles": _cycles,
}
