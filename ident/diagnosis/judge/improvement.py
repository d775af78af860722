"""The improvement of one model over another on test rows or on all rows, with its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.diagnosis.split.split_data import SplitData
from recordings.recording import Bools, Floats

BLOCK_SECONDS = 0.25
"""Rows closer than this are not independent: they are averaged to one block [s]."""
_LEVEL = 0.95
_TINY = 1e-12
"""Relative differences below this are rounding errors, of which Student's t would make anything."""


@dataclass(frozen=True)
class Improvement:
    """Reduction of the mean square, relative to its excess above the noise floor."""

    share: float
    interval: tuple[float, float]
    """95 % interval, by Fieller's theorem from the blocks; simultaneous for all models that were compared."""
    t_statistic: float
    """Student's t of the reduction over the blocks."""
    reduction: float
    """Of the mean square, in units of the squared noise floor."""
    remaining: float
    """Mean square of the second model above the noise floor, in the same units."""
    t_of_ratio: float = 0.0
    """Student's t of the logarithm of the ratio of both mean squares over the blocks. It needs no noise floor, and no
    block outweighs the others."""
    t_for_change: float = 0.0
    """Student's t of the reduction over blocks that count by how much the second model changes there: where both
    models agree, a block tells nothing. It is given as the standard score of the same probability."""


def measure_improvement(
    split: SplitData,
    before: Sequence[Floats],
    after: Sequence[Floats],
    floor: Floats,
    rows: Sequence[Bools] | None = None,
    compared: int = 1,
) -> Improvement:
    """Compare the residuals (m, dof) of every recording `before` and `after`, with the noise `floor` (dof,) [N m].

    Each joint is weighted by its squared noise floor, so that noise counts the same in all joints.

    rows: (m, dof) rows of every recording on which they are compared; default: the test rows.
    compared: number of models among which these rows chose the second one. By Bonferroni's inequality, the intervals
    of all of them together hold the true shares in 95 % of cases, and so the interval of the chosen one does.
    """
    scale, rows = np.maximum(floor, 1e-12), split.test if rows is None else rows
    # An effect may be undefined in more rows than the model without it: compare where both are defined.
    pairs = zip(rows, before, after, strict=True)
    rows = [scored & np.isfinite(old) & np.isfinite(new) for scored, old, new in pairs]
    change = [old - new for old, new in zip(before, after, strict=True)]
    mean_before, mean_after, changed = (
        _block_means(split, residuals, scale, rows) for residuals in (before, after, change)
    )
    return improvement_of_blocks(mean_before, mean_after, 1.0, compared, changed)


def improvement_of_blocks(
    before: Floats, after: Floats, noise: float = 0.0, compared: int = 1, change: Floats | None = None
) -> Improvement:
    """The improvement from the mean squares `before` to those `after` (b,) of independent blocks.

    noise: mean square of the noise floor in the same unit; compared: as in `measure_improvement`; change: mean
    squares (b,) of what the second model changes, if known.
    """
    difference = before - after
    reduction = np.where(np.abs(difference) > _TINY * before, difference, 0.0)
    count = len(reduction)
    if count < 3:
        return Improvement(0.0, (0.0, 0.0), 0.0, 0.0, 0.0)
    spread = float(reduction.std(ddof=1)) / np.sqrt(count)
    excess = before - noise
    share = float(np.clip(reduction.mean() / excess.mean(), -1.0, 1.0)) if excess.mean() > 0 else 0.0
    t = float(reduction.mean() / spread) if spread else 0.0
    return Improvement(
        share,
        _ratio_interval(reduction, excess, 1 - (1 - _LEVEL) / compared),
        t,
        float(reduction.mean()),
        float(after.mean()) - noise,
        _t_of_ratio(before, after),
        0.0 if change is None else _t_for_change(reduction, change),
    )


def _t_of_ratio(before: Floats, after: Floats) -> float:
    """Student's t of the logarithm of the ratio of the mean squares (b,) `before` and `after`."""
    known = (before > 0) & (after > 0)
    logarithm = np.log(before[known]) - np.log(after[known])
    spread = float(logarithm.std(ddof=1)) / np.sqrt(len(logarithm)) if len(logarithm) > 2 else 0.0
    return float(logarithm.mean() / spread) if spread else 0.0


def _t_for_change(reduction: Floats, change: Floats) -> float:
    """See `Improvement.t_for_change`, from the `reduction` and the mean square of the `change` (b,) of blocks.

    A ratio estimator whose errors differ between blocks, with as many degrees of freedom as there are blocks with
    much of the change; Carter, Schnepel and Steigerwald, "Asymptotic behavior of a t-test robust to cluster
    heterogeneity", Rev. Econ. Stat. 99 (2017).
    """
    from scipy.special import ndtri, stdtr

    total = change.sum()
    blocks = total**2 / (change**2).sum() if total > 0 else 0.0
    if blocks <= 2:
        return 0.0
    errors = reduction - reduction.sum() / total * change
    spread = float(np.sqrt((errors**2).sum() * blocks / (blocks - 1)))
    if not spread:
        return 0.0
    return float(-ndtri(stdtr(blocks - 1, -reduction.sum() / spread)))


def _ratio_interval(numerator: Floats, denominator: Floats, level: float) -> tuple[float, float]:
    """Interval of the confidence `level` of the ratio of the means of two samples (b,), within -1 to 1.

    Fieller, "Some problems in interval estimation", J. R. Statist. Soc. B 16 (1954): all ratios r for which the mean
    of numerator - r denominator does not differ from zero by Student's t. If the denominator's own mean does not
    exceed zero significantly, any ratio is possible.
    """
    from scipy.special import stdtrit

    count = len(numerator)
    tolerance = stdtrit(count - 1, (1 + level) / 2) ** 2 / count * np.cov(numerator, denominator)
    mean = np.array([numerator.mean(), denominator.mean()])
    (a, b), (_, c) = np.outer(mean, mean) - tolerance  # the ratios fulfil a - 2 b r + c r^2 <= 0
    if c <= 0 or mean[1] <= 0:
        return -1.0, 1.0
    root = np.sqrt(max(b**2 - a * c, 0.0))
    low, high = np.clip([(b - root) / c, (b + root) / c], -1.0, 1.0)
    return float(low), float(high)


def _block_means(split: SplitData, residuals: Sequence[Floats], scale: Floats, rows: Sequence[Bools]) -> Floats:
    """(b,) mean squares of `rows`, in units of the squared noise floor, over blocks of BLOCK_SECONDS."""
    means = []
    for prepared, selected, residual in zip(split.recordings, rows, residuals, strict=True):
        squares = np.where(selected, (residual / scale) ** 2, 0.0).sum(axis=1)
        block = np.floor(prepared.time / BLOCK_SECONDS).astype(int)
        count = np.bincount(block, selected.sum(axis=1))
        sums = np.bincount(block, squares)
        means.append(sums[count > 0] / count[count > 0])
    return np.concatenate(means)
