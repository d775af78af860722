"""Which SYNC is which, and when it was sent, from nothing but the times at which SYNCs arrived.

Arrivals are late, never early: a host that is busy sends a SYNC late, and several that were due at once afterwards.
So the earliest arrivals tell the time, and a SYNC is known to be missing only when all that follow are a period later
than they would be without a hole.
"""

import numpy as np

from recordings.recording import Floats, Ints

_AHEAD = 500
"""SYNCs that may be late together without being taken for a hole."""
_FOLLOW = 0.02
"""Share of a change of the earliest arrivals that is put down to the clocks, per SYNC."""
_ROUNDS = 12
_OUTLIER = 3.0
"""Arrivals farther from the line than so many typical distances do not count."""
_LAST = 20
"""Among so many last SYNCs no hole is looked for: too few follow to tell lateness from it."""
_NEAR = 0.1
"""Where the configured period leads no farther from the line than this share of itself, it is the period."""


def number(arrival: Ints) -> Ints:
    """(n,) index of each SYNC, counted from the first one with those that are missing, from `arrival` (n,) [ns]."""
    if len(arrival) < 3:
        return np.arange(len(arrival))
    from scipy.ndimage import minimum_filter1d

    period = _period(arrival)
    late = (arrival - arrival[0]) - period * np.arange(len(arrival))
    # The earliest of those that follow: late ones that were only late do not show here.
    width = 2 * min(_AHEAD, len(arrival)) + 1
    backwards = minimum_filter1d(late[::-1], width // 2 + 1, origin=width // 4, mode="nearest")
    following = backwards[::-1]
    following[-_LAST:] = following[-min(_LAST, len(following))]
    holes = np.zeros(len(arrival), np.int64)
    level = float(following[0])
    missing = 0
    for i, value in enumerate(following.tolist()):
        jump = round((value - level) / period)
        if jump > 0:
            missing += jump
            level += jump * period
        level += _FOLLOW * (value - level)
        holes[i] = missing
    index: Ints = np.arange(len(arrival)) + holes
    return index


def _period(arrival: Ints) -> float:
    """[ns] from pieces long enough for lateness not to matter; pieces with holes are outnumbered."""
    lag = min(200, len(arrival) // 2)
    return float(np.median(arrival[lag:] - arrival[:-lag])) / lag


def line(arrival: Ints, index: Ints, configured: float) -> tuple[int, float]:
    """Time of SYNC 0 [ns] and the period [ns] of a robust line through the arrivals (n,) [ns].

    Two clocks are never quite alike, so the period is not the `configured` one [ns]. Where the arrivals do not
    contradict it, because the sender's clock is ours, it is.
    """
    if len(arrival) < 2:
        return int(arrival[0]), configured
    start, period = _fit(index, arrival - arrival[0])
    if abs(period - configured) * (index[-1] + 1) <= 2 * _NEAR * configured:
        period = configured
        start = float(np.median((arrival - arrival[0]) - index * period))
    return int(arrival[0]) + round(start), period


def _fit(index: Ints, arrival: Ints) -> tuple[float, float]:
    """Least squares without outliers, which are those far from the line of the round before."""
    x, y = index.astype(np.float64), arrival.astype(np.float64)
    keep = np.ones(len(x), bool)
    start, period = 0.0, 0.0
    for _ in range(_ROUNDS):
        centre = x[keep].mean()
        centred = x[keep] - centre
        period = float(centred @ y[keep] / (centred @ centred))
        start = float(y[keep].mean() - period * centre)
        off: Floats = y - (start + period * x)
        off -= np.median(off)
        before, keep = keep, np.abs(off) <= _OUTLIER * max(float(np.median(np.abs(off))), 1.0)
        if keep.sum() < 2 or (keep == before).all():
            break
    return start, period
