"""Detecting the repeated cycles of a motion from the measured motion."""

from dataclasses import dataclass

import numpy as np

from recordings.interpolation import interpolate_columns
from recordings.recording import Floats, Ints
from recordings.resolution import resolution

_MIN_PERIOD = 20
"""Shortest period sought [samples]."""
_SEARCH_SAMPLES = 100_000
"""Number of samples, after decimation, in the first search for periods."""
_MAX_PERIOD_FRACTION = 0.6
"""Longest period sought, as a fraction of the moving part; above one half because its ends may look like rest."""
_MAX_DIFFERENCE = 0.8
"""Largest mean square difference at a candidate period, relative to the median over all lags.

The difference is that of the motion and itself one period later. The threshold is loose because the approach to the
motion and the way back may contribute much."""
_MAX_EXCESS = 0.3
"""Allowed excess of a candidate over the best one, in the same measure: half a period may score better than one."""
_MAX_CANDIDATES = 8
"""Largest number of candidate periods."""
_SEARCH_RANGE = 0.03
"""Relative search range around a proposed period."""
_SEARCH_STEPS = 100
"""Lags tried on each side of a proposed period."""
_COMPARED_SAMPLES = 5000
"""Number of samples at which periods are compared."""
_TOLERANCE = 0.02
"""Largest difference between repetitions, relative to the range of motion of the joint."""
_TOLERANCE_FACTOR = 3.0
"""The repeated part ends where the difference exceeds this multiple of its 99 % quantile inside."""
_STEPS = 2.5
"""Positions of equal repetitions differ by up to two encoder steps: one of rounding and one of noise."""
_TRACES = np.geomspace(1e-5, 1e-3, 8).tolist()
"""Tolerances that are tried, relative to the range of motion: what is left of the approach fades, and encoder steps
are not known where positions were rounded again."""
_ROUNDING = 1e-12
"""Allowance for rounding."""
_MIN_COVERAGE = 0.7
"""Smallest length of an accepted repeated part, as a fraction of the longest one."""


@dataclass(frozen=True)
class Cycles:
    """`count` repetitions of `period` samples each, from sample `first` on."""

    first: int
    period: int
    count: int

    def repeat(self, n: int) -> Ints:
        """Repetition (n,) to which each of n samples belongs, -1 outside all repetitions."""
        repeat = np.full(n, -1)
        repeat[self.first : self.first + self.period * self.count] = np.repeat(np.arange(self.count), self.period)
        return repeat


def find_cycles(motion: Floats) -> Cycles | None:
    """Find the repetitions in `motion` (n, dof), evenly sampled, NaN where unknown; None where nothing repeats.

    The period is the shortest one after which all joints return to the same position. Rest before and after is
    ignored; other motion before and after must be shorter than the repeated part. The start of a cycle cannot be
    determined, so the first cycle begins with the first sample that repeats.
    """
    x = _normalised(motion)
    start, end = _moving_range(x)
    if end - start < 2 * _MIN_PERIOD:
        return None
    moving = _interpolated(x[start:end])
    stride = 1 + len(moving) // _SEARCH_SAMPLES
    proposed = [
        _coarsely_refined(moving, stride * period, stride)
        for period in _periods(moving[::stride], shortest=-(-_MIN_PERIOD // stride))
    ]
    candidates = [
        cycles for period in dict.fromkeys(proposed) if (cycles := _repeated_range(x, period, start, end)) is not None
    ]
    # Multiples of the period repeat too, and so may a part of the motion: take the shortest that covers most of it.
    longest = max((cycles.period * cycles.count for cycles in candidates), default=0)
    covering = [cycles for cycles in candidates if cycles.period * cycles.count > _MIN_COVERAGE * longest]
    return min(covering, key=lambda cycles: cycles.period, default=None)


def _normalised(motion: Floats) -> Floats:
    """Positions of the moving joints, centred and scaled to range 1."""
    columns = []
    for column in motion.T:
        known = column[np.isfinite(column)]
        if len(known) and np.ptp(known) > 0:
            columns.append((column - known.mean()) / np.ptp(known))
    return np.column_stack(columns) if columns else np.empty((len(motion), 0))


def _interpolated(x: Floats) -> Floats:
    """`x` (n, dof) with its gaps filled by linear interpolation."""
    index = np.arange(len(x), dtype=float)
    return interpolate_columns(index, index, x)


def _moving_range(x: Floats) -> tuple[int, int]:
    """Start and end index of `x` without rest at the beginning and at the end."""
    known = np.flatnonzero(np.isfinite(x).all(axis=1) & (x.shape[1] > 0))
    if not len(known):
        return 0, 0
    from_start = np.flatnonzero((np.abs(x - x[known[0]]) > _TOLERANCE).any(axis=1))
    from_end = np.flatnonzero((np.abs(x - x[known[-1]]) > _TOLERANCE).any(axis=1))
    return max(int(from_start[0]) - 1, 0), min(int(from_end[-1]) + 2, len(x))


def _periods(x: Floats, shortest: int) -> list[int]:
    """Candidate periods of `x` (n, dof) from `shortest` [samples], in ascending order."""
    difference = _difference(x)
    ordinary = float(np.median(difference))
    lags = np.arange(shortest, len(difference) - 1)
    minimum = (difference[lags] <= difference[lags - 1]) & (difference[lags] < difference[lags + 1])
    lags = lags[minimum & (difference[lags] < _MAX_DIFFERENCE * ordinary)]
    if not len(lags):
        return []
    good = lags[difference[lags] <= difference[lags].min() + _MAX_EXCESS * ordinary]
    return [int(lag) for lag in good[:_MAX_CANDIDATES]]


def _difference(x: Floats) -> Floats:
    """Mean square of x(t + lag) - x(t) summed over all joints, (lags,), computed from the autocorrelation."""
    from scipy.fft import irfft, next_fast_len, rfft

    n = len(x)
    size = next_fast_len(2 * n, real=True)
    spectrum = rfft(x, size, axis=0)
    correlation = irfft((spectrum * spectrum.conj()).real.sum(axis=1), size)[: int(_MAX_PERIOD_FRACTION * n)]
    energy = np.concatenate([[0.0], np.cumsum((x**2).sum(axis=1))])
    lags = np.arange(len(correlation))
    pairs = n - lags
    return np.maximum((energy[pairs] + energy[n] - energy[lags] - 2 * correlation) / pairs, 0)


def _coarsely_refined(x: Floats, period: int, reach: int) -> int:
    """Period near `period` at which the best quarter of the motion repeats best; the rest may not repeat."""
    reach = max(2 * reach, int(_SEARCH_RANGE * period))
    # `_refined` later finds the exact period between these steps.
    step = 1 + reach // _SEARCH_STEPS
    lags = np.arange(max(period - reach, _MIN_PERIOD), min(period + reach, len(x) - 2) + 1, step)
    rows = np.linspace(0, len(x) - 1 - lags[-1], _COMPARED_SAMPLES).astype(np.int64)
    worst = [np.quantile(np.abs(x[rows + lag] - x[rows]).max(axis=1), 0.25) for lag in lags]
    return int(lags[np.argmin(worst)])


def _repeated_range(x: Floats, period: int, start: int, end: int) -> Cycles | None:
    """Range in which the motion, at rest outside `start` to `end`, repeats with about this period, if it does."""
    low = max(start - period, 0)
    x = x[low : end + period]
    first, length = _longest_run(_mismatch(x, period) <= _TOLERANCE)
    if length < period // 2:
        return None
    inner = slice(first + length // 4, first + length - length // 4)
    period = _refined(x, period, inner)
    mismatch = _mismatch(x, period)
    # Exact repetitions end sharply, noisy ones do not: repeat with a tolerance adapted to this motion.
    spread = _TOLERANCE_FACTOR * float(np.quantile(mismatch[inner], 0.99))
    # The first repetition may begin slightly beside the others: take the smallest tolerance with most repetitions.
    tolerances = sorted(max(spread, each) for each in (0.0, *_TRACES, _encoder_steps(x)))
    first, length, count = max((_within(mismatch, period, each) for each in tolerances), key=lambda run: run[2])
    if count < 2 or np.nanmax(np.ptp(_interpolated(x[first : first + length]), axis=0)) < 10 * _TOLERANCE:
        return None
    return Cycles(low + first, period, count)


def _within(mismatch: Floats, period: int, tolerance: float) -> tuple[int, int, int]:
    """First sample, length and number of repetitions of the longest run that repeats within `tolerance`."""
    first, length = _longest_run(mismatch <= min(tolerance + _ROUNDING, _TOLERANCE))
    return first, length, (length + period) // period


def _mismatch(x: Floats, period: int) -> Floats:
    """Largest absolute difference over the joints between the motion and itself one period later, (n - period,).

    Unknown samples count as zero difference.
    """
    return np.nan_to_num(np.abs(x[period:] - x[:-period])).max(axis=1)


def _encoder_steps(x: Floats) -> float:
    """Difference by which positions of equal repetitions may differ, because encoders round; 0 without rounding."""
    return _STEPS * max((resolution(column) or 0.0 for column in x.T), default=0.0)


def _refined(x: Floats, period: int, inner: slice) -> int:
    """Period near `period` at which the samples `inner` repeat best, found by descent."""
    rows = np.arange(inner.start, inner.stop, 1 + (inner.stop - inner.start) // _COMPARED_SAMPLES)

    def mean(lag: int) -> float:
        return float(np.nan_to_num(np.abs(x[rows + lag] - x[rows])).max(axis=1).mean())

    while True:
        near = [lag for lag in (period, period - 1, period + 1) if _MIN_PERIOD <= lag < len(x) - inner.stop]
        best = min(near, key=mean)
        if best == period:
            return period
        period = best


def _longest_run(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[int, int]:
    """First index and length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return 0, 0
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest] - starts[longest])
