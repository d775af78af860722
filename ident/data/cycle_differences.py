"""Noise of a repeated motion, from the differences between consecutive cycles that no event disturbs.

A payload that is picked up, a slip or a changed gain is no noise. At every phase of the motion, a change at one
instant disturbs only one of the differences between consecutive cycles, and a cycle that differs from all others two.
So the differences of the same phases are compared with each other, and the disturbed ones are left out.
"""

from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import TINY
from recordings.recording import Bools, Floats

_BLOCK_FREEDOM = 20.0
"""Degrees of freedom of the noise in a block of phases: enough to compare mean squares, few enough to find events."""
_DISTURBED_P = 0.0001
"""A difference is disturbed if its mean square in a block would be so large with this probability."""
_COARSE = 8
"""Number of blocks to find the quietest differences, before the degrees of freedom of the noise are known."""


@dataclass(frozen=True, eq=False)
class CycleDifferences:
    """Differences of one joint between consecutive cycles."""

    values: Floats
    """(cycles - 1, phases), NaN where a cycle has no row or an event disturbs the difference."""
    freedom: float
    """Effective degrees of freedom of the noise of one cycle."""
    noise: float
    """Variance of the noise of a single cycle."""
    disturbed: bool
    """Whether an event disturbs any of them."""


def cycle_differences(x: Floats) -> CycleDifferences | None:
    """The undisturbed differences in `x` (cycles, phases); None if no two consecutive cycles share a phase."""
    repeated = np.isfinite(np.diff(x, axis=0)).any(axis=0)
    if not repeated.any():
        return None
    differences, cycles = np.diff(x, axis=0)[:, repeated], x[:, repeated]
    freedom = _freedom_of_quietest(differences)
    edges = _edges(differences.shape[1], int(freedom / _BLOCK_FREEDOM))
    width = np.diff(edges)
    limit = _largest_ratio(max(freedom / len(width), 1.0))
    squares = _block_mean_squares(differences, edges)
    disturbed = _whole_events(squares > limit * _lower_median(squares), np.isfinite(squares))
    undisturbed = np.where(np.repeat(disturbed, width, axis=1), np.nan, differences)
    # The variance about the mean cycle is more precise, where no event disturbs it.
    variance = np.where(
        disturbed.any(axis=0),
        np.nanmean(np.where(disturbed, np.nan, squares), axis=0) / 2,
        np.add.reduceat(between_cycles(cycles), edges[:-1]) / width,
    )
    if len(x) < 3:  # no difference to spare: an event shows only by comparison with other phases
        variance = np.minimum(variance, limit * np.median(variance))
    values = np.full((len(x) - 1, x.shape[1]), np.nan)
    values[:, repeated] = undisturbed
    return CycleDifferences(
        values, degrees_of_freedom(undisturbed), float(np.average(variance, weights=width)), bool(disturbed.any())
    )


def between_cycles(x: Floats) -> Floats:
    """(phases,) variance of `x` (cycles, phases) about the mean cycle; the phases occur twice at least."""
    count = np.isfinite(x).sum(axis=0)
    return np.nansum((x - np.nansum(x, axis=0) / count) ** 2, axis=0) / (count - 1)


def deviation_within_groups(x: Floats, differences: CycleDifferences) -> tuple[Floats, int]:
    """Deviation of `x` (cycles, phases) from the mean of consecutive cycles with undisturbed `differences`.

    NaN in a cycle that stands alone. Returns also the number of groups of cycles, over all phases.
    """
    cycles, phases = x.shape
    group = np.concatenate([np.zeros((1, phases), int), np.cumsum(np.isnan(differences.values), axis=0)])
    key = (group * phases + np.arange(phases)).ravel()
    count = np.bincount(key, np.isfinite(x).ravel(), cycles * phases)
    mean = np.bincount(key, np.nan_to_num(x).ravel(), cycles * phases) / np.maximum(count, 1)
    return np.where(count[key] > 1, x.ravel() - mean[key], np.nan).reshape(x.shape), int((count > 1).sum())


def degrees_of_freedom(differences: Floats) -> float:
    """Effective degrees of freedom of the noise of one cycle, in a sum of squares, from (rows, phases) of noise.

    For Gaussian noise of covariance S along the phase this is (tr S)^2 / tr S^2. The local variance and the
    autocorrelation of S are estimated from all rows; the variance of these estimates is subtracted.
    """
    count = np.maximum(np.isfinite(differences).sum(axis=0), 1)
    variance = np.nansum(differences**2, axis=0) / count
    if not variance.any():
        return 1.0
    phases, rows = len(variance), float(count.mean())
    unit = np.nan_to_num(differences / np.sqrt(np.where(variance > 0, variance, np.inf)))
    lags = max(phases // 4, 1)
    correlation = _autocorrelation(unit, lags) / (unit**2).sum()
    chance = 1 / (phases * rows)
    squared = np.maximum(correlation**2 - chance, 0.0) / (1 + 2 * correlation**2 / rows)
    squared[0] = 1 / (1 + 2 / rows)
    terms = squared * _autocorrelation(variance[None], lags)
    return max(float(variance.sum()) ** 2 / float(2 * terms.sum() - terms[0]), 1.0)


def _autocorrelation(x: Floats, lags: int) -> Floats:
    """(lags,) sums of products along the rows of `x` (rows, phases)."""
    spectrum = np.abs(np.fft.rfft(x, 2 * x.shape[1], axis=1)) ** 2
    return np.fft.irfft(spectrum.sum(axis=0))[:lags]


def _freedom_of_quietest(differences: Floats) -> float:
    """Degrees of freedom of the noise, from the pair of cycles that differs least in each of the quieter blocks."""
    edges = _edges(differences.shape[1], _COARSE)
    squares = _block_mean_squares(differences, edges)
    least = np.nanmin(squares, axis=0)
    width = np.diff(edges)
    pair, quiet = np.repeat(np.nanargmin(squares, axis=0), width), np.repeat(least <= np.median(least), width)
    rows = differences[pair, np.arange(differences.shape[1])]
    return degrees_of_freedom(rows[None, quiet]) / float(quiet.mean())


def _edges(phases: int, blocks: int) -> np.ndarray:
    """(blocks + 1,) edges of blocks of phases of nearly equal length."""
    return np.linspace(0, phases, min(max(blocks, 1), phases) + 1).astype(int)


def _block_mean_squares(differences: Floats, edges: np.ndarray) -> Floats:
    """(pairs, blocks) mean squares, NaN where a pair of cycles has much fewer rows than others."""
    count = np.add.reduceat(np.isfinite(differences).astype(float), edges[:-1], axis=1)
    sums = np.add.reduceat(np.nan_to_num(differences**2), edges[:-1], axis=1)
    enough = (count > 0) & (count >= count.max(axis=0) / 2)
    return np.where(enough, sums / np.maximum(count, 1), np.nan)


def _lower_median(squares: Floats) -> Floats:
    """(blocks,) median of the pairs; of an even number, the lower of the two in the middle."""
    ordered = np.sort(squares, axis=0)  # NaN last
    middle = (np.isfinite(squares).sum(axis=0) - 1) // 2
    return np.take_along_axis(ordered, middle[None], axis=0)[0] + TINY


def _whole_events(disturbed: Bools, known: Bools) -> Bools:
    """All blocks (pairs, blocks) that an event disturbs: those between two `disturbed` ones less than a cycle apart.

    A change at one instant disturbs the differences of a whole cycle, but not always visibly. If no difference of a
    `known` block is left, only the visible ones are disturbed.
    """
    in_time, place = disturbed.ravel(), np.arange(disturbed.size)
    before = np.maximum.accumulate(np.where(in_time, place, -disturbed.size))
    after = np.minimum.accumulate(np.where(in_time, place, 2 * disturbed.size)[::-1])[::-1]
    between = (after - before < disturbed.shape[1]).reshape(disturbed.shape)
    return np.where((between | ~known).all(axis=0), disturbed, between)


def _largest_ratio(freedom: float) -> float:
    """Largest ratio of two mean squares of noise of so many degrees of freedom."""
    from scipy.special import fdtri

    return float(fdtri(freedom, freedom, 1 - _DISTURBED_P))
