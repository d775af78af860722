"""The improvement of one model over another on rows that no fit used, and when it is confirmed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.diagnosis.split.split_data import TINY, SplitData
from ident.uncertainty.covariance import LEVEL
from recordings.recording import Bools, Floats, Ints

MIN_T = 3.5
"""Student's t that confirms an improvement on held-out rows; it is high because many models are tried."""
NONZERO_T = 1.96
"""Student's t above which the 95 % interval of an improvement does not hold zero."""
MIN_SHARE = 0.1
"""Share of the mean square above the noise floor that an effect must take: with much data, negligible effects are
significant."""
BLOCK_SECONDS = 0.25
"""Rows closer than this are not independent: they are averaged to one block [s]."""


@dataclass(frozen=True)
class Improvement:
    """Reduction of the mean square, relative to its excess above the noise floor."""

    share: float
    interval: tuple[float, float]
    """95 % interval, by Fieller's theorem from the blocks; simultaneous for all models that were compared."""
    t: float
    """Student's t over the blocks, as the standard score of the same probability: of the reduction, or, where that is
    not negligible, of the logarithm of the ratio of both mean squares, which no block outweighs."""
    reduction: float
    """Of the mean square, in units of the squared noise floor."""
    remaining: float
    """Mean square of the second model above the noise floor, in the same units."""

    @property
    def is_small(self) -> bool:
        """Whether it takes less than MIN_SHARE of what is left above the noise floor, or nothing was left there."""
        excess = self.remaining + self.reduction
        return excess <= 0 or self.reduction < MIN_SHARE * excess

    @property
    def pays(self) -> bool:
        """Whether it is of the minimum size, and more than nothing: what one joint of several has to show."""
        return not self.is_small and self.t > NONZERO_T

    @property
    def is_supported(self) -> bool:
        """Whether the rows confirm it."""
        return self.t > MIN_T


@dataclass(frozen=True, eq=False)
class Blocks:
    """Sums of squares (b, dof) of independent blocks of rows [(N m)^2]."""

    before: Floats
    after: Floats
    """Both with the noise that the model smooths, which is no improvement."""
    change: Floats
    """Of what the second model changes: where both models agree, a block tells nothing."""
    count: Floats
    """(b, dof) number of rows."""
    floor: Floats
    """(dof,) squared noise floor [(N m)^2]."""

    @classmethod
    def of(
        cls,
        split: SplitData,
        before: Sequence[Floats],
        after: Sequence[Floats],
        floor: Floats,
        rows: Sequence[Bools],
        smoothed: Sequence[Floats | float] = (0.0, 0.0),
    ) -> "Blocks":
        """Those of the residuals (m, dof) of every recording `before` and `after`, in the `rows` (m, dof).

        floor: (dof,) noise floor [N m]; smoothed: (dof,) mean square of the noise that each model smooths [(N m)^2].
        """
        # An effect may be undefined in more rows than the model without it: compare where both are defined.
        rows = [
            scored & np.isfinite(old) & np.isfinite(new) for scored, old, new in zip(rows, before, after, strict=True)
        ]
        change = [old - new for old, new in zip(before, after, strict=True)]
        squares = (
            [np.where(r, x**2, 0.0) for r, x in zip(rows, each, strict=True)] for each in (before, after, change)
        )
        sums = [_block_sums(split, rows, each) for each in (*squares, [selected.astype(float) for selected in rows])]
        old, new, changed, count = sums
        left = (old + count * smoothed[0], new + count * smoothed[1])
        return cls(*left, changed, count, np.maximum(floor, TINY) ** 2)

    def __add__(self, other: "Blocks") -> "Blocks":
        """The blocks of both."""
        sums = {name: np.concatenate([own, vars(other)[name]]) for name, own in vars(self).items() if name != "floor"}
        return replace(self, **sums)

    @property
    def scale(self) -> Floats:
        """(dof,) mean square by which each joint counts: its own excess above the noise floor, or at least the floor.

        So none makes the others negligible.
        """
        return np.maximum(self.before.sum(axis=0) / np.maximum(self.count.sum(axis=0), 1.0) - self.floor, self.floor)

    @property
    def reduction(self) -> Floats:
        """(dof,) fall of the mean square of each joint [(N m)^2]."""
        return (self.before - self.after).sum(axis=0) / np.maximum(self.count.sum(axis=0), 1.0)

    def improvement(self, compared: int = 1, joints: Sequence[int] | None = None) -> Improvement:
        """The improvement over all blocks, on `joints` (from 0); None: on those on which the models differ.

        compared: number of models among which these rows chose the second one. By Bonferroni's inequality, the
        intervals of all of them together hold the true shares in 95 % of cases, and so the interval of the chosen one
        does.
        """
        scale = self.scale
        if joints is None:
            changed = self.change.sum(axis=0) / np.maximum(self.count.sum(axis=0), 1.0) / scale
            joints = np.flatnonzero(changed >= MIN_SHARE * changed.max()).tolist()
        chosen = list(joints)
        rows = self.count[:, chosen].sum(axis=1)
        known = rows > 0
        before, after, change, noise = (
            (sums[:, chosen] / scale[chosen]).sum(axis=1)[known] / rows[known].mean()
            for sums in (self.before, self.after, self.change, self.count * self.floor)
        )
        return improvement_of_blocks(before, after, noise, compared, change)


def in_turn(
    held_out: Improvement, other_way: Callable[[], tuple[Improvement, Improvement]], required: float = MIN_T
) -> Improvement:
    """`held_out` with Student's t of all rows, each held out once, where it lacks the power and both halves improve.

    other_way: the improvement on the training rows by fits to the held-out ones, and that on both; required: t.
    """
    if held_out.is_small or not required / 2 < held_out.t <= required:
        return held_out
    turned, both = other_way()
    return held_out if turned.is_small else replace(held_out, t=max(held_out.t, both.t))


def improvement_of_blocks(
    before: Floats, after: Floats, noise: Floats | None = None, compared: int = 1, change: Floats | None = None
) -> Improvement:
    """The improvement from the mean squares `before` to those `after` (b,) of independent blocks.

    noise: (b,) mean squares of the noise floor in the same unit; None: what is left is no noise, and the unit is that
    of the squares; compared: as in `Blocks.improvement`; change: mean squares (b,) of what the second model changes;
    None: the same in all blocks.
    """
    difference = before - after
    reduction = np.where(np.abs(difference) > TINY * before, difference, 0.0)
    if len(reduction) <= 2:
        return Improvement(0.0, (0.0, 0.0), 0.0, 0.0, 0.0)
    excess = before if noise is None else before - noise
    unit = 1.0 if noise is None else float(noise.mean())
    share = float(np.clip(reduction.mean() / excess.mean(), -1.0, 1.0)) if excess.mean() > 0 else 0.0
    improvement = Improvement(
        share,
        _ratio_interval(reduction, excess, 1 - (1 - LEVEL) / compared),
        _standard_score(reduction, change),
        float(reduction.mean()) / unit,
        float((excess - difference).mean()) / unit,
    )
    if improvement.is_small:
        return improvement
    known = (before > 0) & (after > 0)
    return replace(improvement, t=max(improvement.t, _standard_score(np.log(before[known]) - np.log(after[known]))))


def _standard_score(values: Floats, weights: Floats | None = None) -> float:
    """Student's t of the sum of `values` (b,) of independent blocks, as the standard score of the same probability.

    A ratio estimator whose errors differ between blocks, with as many degrees of freedom as there are blocks with
    much of the `weights` (b,), to which values are proportional; None: the same in all, Student's t. Carter, Schnepel
    and Steigerwald, "Asymptotic behavior of a t-test robust to cluster heterogeneity", Rev. Econ. Stat. 99 (2017).
    """
    from scipy.special import ndtri, stdtr

    weights = np.ones_like(values) if weights is None else weights
    total = weights.sum()
    blocks = total**2 / (weights**2).sum() if total > 0 else 0.0
    if blocks <= 2:
        return 0.0
    errors = values - values.sum() / total * weights
    spread = float(np.sqrt((errors**2).sum() * blocks / (blocks - 1)))
    together = float(values.sum())
    t = together / max(spread, TINY * abs(together), float(np.finfo(float).tiny))
    probability = max(float(stdtr(blocks - 1, -abs(t))), float(np.finfo(float).tiny))
    return float(np.copysign(ndtri(probability), t))


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


def block_means(blocks: Ints, values: Floats) -> Floats:
    """(b,) means of the `values` (n,) over each of the `blocks` (n,) that has any."""
    count = np.bincount(blocks)
    return np.bincount(blocks, values)[count > 0] / count[count > 0]


def _block_sums(split: SplitData, rows: Sequence[Bools], values: Sequence[Floats]) -> Floats:
    """(b, dof) sums of the `values` (m, dof) of every recording over blocks of BLOCK_SECONDS that have `rows`."""
    sums = []
    for prepared, selected, each in zip(split.recordings, rows, values, strict=True):
        block = np.floor(prepared.time / BLOCK_SECONDS).astype(int)
        known = np.bincount(block, selected.any(axis=1)) > 0
        sums.append(np.stack([np.bincount(block, column)[known] for column in each.T], axis=1))
    return np.concatenate(sums)
