"""Numbers and times of the SYNCs, estimated from their arrival times only.

Arrivals are late, never early: a busy host sends a SYNC late, and then several overdue ones at once. So the earliest
arrivals define the time, and a SYNC counts as missing only if all later SYNCs come a period later than they would
without the gap.
"""

import numpy as np

from recordings.recording import Floats, Ints

_MAX_LATE_SYNCS = 500
"""Number of successive SYNCs that may be late together without being taken for a gap."""
_DRIFT_SHARE = 0.02
"""Share per SYNC of a change of the earliest arrivals that is attributed to clock drift."""
_ITERATIONS = 12
_OUTLIER_FACTOR = 3.0
"""Arrivals farther from the line than this multiple of the median distance are outliers."""
_TAIL = 20
"""Number of last SYNCs among which no gap is detected: too few follow to distinguish it from lateness."""
_PERIOD_TOLERANCE = 0.1
"""The configured period is kept if it leads no farther from the line than this share of a period."""


def number_syncs(arrival: Ints) -> Ints:
    """Number each SYNC (n,) from 0, counting missing ones, from the arrival times `arrival` (n,) [ns]."""
    if len(arrival) < 3:
        return np.arange(len(arrival))
    from scipy.ndimage import minimum_filter1d

    period = _period(arrival)
    late = (arrival - arrival[0]) - period * np.arange(len(arrival))
    # Minimum over the following SYNCs: SYNCs that are merely late do not appear in it.
    width = 2 * min(_MAX_LATE_SYNCS, len(arrival)) + 1
    backwards = minimum_filter1d(late[::-1], width // 2 + 1, origin=width // 4, mode="nearest")
    earliest_following = backwards[::-1]
    earliest_following[-_TAIL:] = earliest_following[-min(_TAIL, len(earliest_following))]
    missing_before = np.zeros(len(arrival), np.int64)
    level = float(earliest_following[0])
    missing = 0
    for i, value in enumerate(earliest_following.tolist()):
        jump = round((value - level) / period)
        if jump > 0:
            missing += jump
            level += jump * period
        level += _DRIFT_SHARE * (value - level)
        missing_before[i] = missing
    return np.arange(len(arrival)) + missing_before


def _period(arrival: Ints) -> float:
    """Median period [ns] over segments so long that lateness does not matter; one gap is in a third of them."""
    lag = min(200, max(len(arrival) // 4, 1))
    return float(np.median(arrival[lag:] - arrival[:-lag])) / lag


def fit_line(arrival: Ints, index: Ints, configured: float) -> tuple[int, float]:
    """Fit a robust line to the arrivals (n,) [ns]; return the time of SYNC 0 [ns] and the period [ns].

    Two clocks differ, so the period is estimated. If the arrivals agree with the `configured` period [ns], because
    the sender uses the clock of this computer, that period is returned.
    """
    if len(arrival) < 2:
        return int(arrival[0]), configured
    start, period = _fit(index, arrival - arrival[0])
    if abs(period - configured) * (index[-1] + 1) <= 2 * _PERIOD_TOLERANCE * configured:
        period = configured
        start = float(np.median((arrival - arrival[0]) - index * period))
    return int(arrival[0]) + round(start), period


def _fit(index: Ints, arrival: Ints) -> tuple[float, float]:
    """Least squares without outliers, which are far from the line of the previous iteration."""
    x, y = index.astype(np.float64), arrival.astype(np.float64)
    keep = np.ones(len(x), bool)
    start, period = 0.0, 0.0
    for _ in range(_ITERATIONS):
        centre = x[keep].mean()
        centred = x[keep] - centre
        period = float(centred @ y[keep] / (centred @ centred))
        start = float(y[keep].mean() - period * centre)
        residual: Floats = y - (start + period * x)
        residual -= np.median(residual)
        previous, keep = keep, np.abs(residual) <= _OUTLIER_FACTOR * max(float(np.median(np.abs(residual))), 1.0)
        if keep.sum() < 2 or (keep == previous).all():
            break
    return start, period
