"""Whether means of blocks leave the range that they had before: e-processes of places that are visited repeatedly.

Null hypothesis: at place p the mean of a block is x = mu + noise, with any mu in a known range that may change from
visit to visit, and normal noise of at most the standard deviation s_p, independent of the visits before. Whoever bets
before a visit that x comes from another normal distribution gets the ratio of its density to the largest density that
the null hypothesis allows at x: in expectation at most 1 (universal inference, Wasserman et al., 2020). Half of the
capital is staked each time, so that an odd block costs no more than that. The capital is an e-process for each joint,
direction of motion and kind of change: by Ville's inequality it exceeds 100 in at most one of a hundred runs, however
long, and so does the mean of all of them.

Blocks next to each other may be correlated: bets are made by earlier visits only, and with s_p of the long-run
variance, which bounds the covariance of any weighted sum of blocks.
"""

import numpy as np

from recordings.recording import Bools, Floats, Ints

KINDS = ("sudden", "growing")
_WEIGHT = 0.5
"""Of the newest visit in the level that a bet on a growing change expects."""
_LEVEL_VARIANCE = _WEIGHT / (2 - _WEIGHT)
"""Variance of that level, in units of a block's."""


class RangeEvidence:
    """E-processes of all joints (dof), directions (2) and KINDS (2)."""

    def __init__(self, low: Floats, high: Floats, std: Floats) -> None:
        """Range and standard deviation of a block at each place and joint (places, dof); NaN: never counted."""
        self._low, self._high, self._std = low, high, std
        self.level = np.clip(np.zeros_like(low), low, high)
        """(places, dof) level of the last visits."""
        self._total, self._visits = np.zeros((2, *low.shape))
        self.log_e = np.zeros((low.shape[1], 2, len(KINDS)))
        """(dof, 2, kinds) logarithm of each e-process."""

    @property
    def log_evidence(self) -> float:
        """Logarithm of the mean of all e-processes, an e-process, too."""
        return float(np.logaddexp.reduce(self.log_e, axis=None) - np.log(self.log_e.size))

    def excess(self) -> Floats:
        """(places, dof) by how much the level of the last visits is outside of the range; with its sign."""
        return self.level - np.clip(self.level, self._low, self._high)

    def observe(self, place: int, mean: Floats, counted: Bools, direction: Ints) -> None:
        """Take a block at `place`: its `mean` (dof,), the joints that count (dof,), their direction (dof,) 0 or 1."""
        low, high, std = self._low[place], self._high[place], self._std[place]
        counted = counted & np.isfinite(low)
        visits, level = self._visits[place], self.level[place]
        since = self._total[place] / np.maximum(visits, 1)
        for kind, (expected, variance) in enumerate(((since, 1 / np.maximum(visits, 1)), (level, _LEVEL_VARIANCE))):
            stake = counted & (visits > 0) & (np.clip(expected, low, high) != expected)
            best = np.clip(mean, low, high)
            with np.errstate(invalid="ignore"):  # of joints that do not count
                ratio = ((mean - best) / std) ** 2 - ((mean - expected) / std) ** 2 / (1 + variance)
                log_factor = (ratio - np.log1p(variance)) / 2
                gain = np.where(stake, np.logaddexp(0.0, log_factor) - np.log(2), 0.0)
            self.log_e[np.arange(len(mean)), direction, kind] += gain
        self._remember(place, mean, counted)

    def _remember(self, place: int, mean: Floats, counted: Bools) -> None:
        """Keep the level, and the sum of visits since the level left the range."""
        level = np.where(counted, (1 - _WEIGHT) * self.level[place] + _WEIGHT * mean, self.level[place])
        self.level[place] = level
        outside = np.clip(level, self._low[place], self._high[place]) != level
        for entry, one in ((self._total, mean), (self._visits, np.ones_like(mean))):
            entry[place] = np.where(counted, np.where(outside, entry[place] + one, 0.0), entry[place])
