"""Finding the repeated cycles of a motion from the motion itself."""

from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats, Ints

_LEAST_PERIOD = 20
"""Samples."""
_THINNED = 100_000
"""Samples among which periods are sought first."""
_FARTHEST = 0.6
"""Longest period sought, relative to the moving part: a little more than half, as its ends may look like rest."""
_ALIKE = 0.8
"""A period is looked into where the mean square difference of the motion and itself a period later is a minimum and
below this share of the ordinary one. Much of it may be due to the way to the motion and back."""
_NEARLY = 0.3
"""How much above the best one it may be, in the same measure: half a period may look better than a whole one."""
_CANDIDATES = 8
"""Periods that are looked into."""
_SHARPEN = 0.03
"""A proposed period may be so far from the true one, relatively."""
_STEPS = 100
_LOOKS = 5000
"""Samples at which periods are compared."""
_TOLERANCE = 0.02
"""A repetition comes back this near, relative to the range of the joint's motion."""
_MARGIN = 3.0
"""The repeated part ends where the difference exceeds what it is within by this factor."""
_EXACT = 1e-12
"""Rounding."""
_MOST = 0.7
"""Share of the longest repeated part that another one must have to be the same."""


@dataclass(frozen=True)
class Cycles:
    """`count` repetitions of `period` samples each, from sample `first` on."""

    first: int
    period: int
    count: int

    def repeat(self, n: int) -> Ints:
        """(n,) repetition that each of n samples belongs to, -1 outside of all."""
        repeat = np.full(n, -1)
        repeat[self.first : self.first + self.period * self.count] = np.repeat(np.arange(self.count), self.period)
        return repeat


def find_cycles(motion: Floats) -> Cycles | None:
    """The repetitions in `motion` (n, dof), evenly sampled, NaN where unknown; None where nothing repeats.

    The period is the shortest at which all joints together come back to where they were. Rest before and after does
    not matter; other motion before and after has to be shorter than what repeats. Where a cycle begins cannot be
    known: the first one begins with the first sample that repeats.
    """
    x = _normalised(motion)
    start, end = _moving_range(x)
    if end - start < 2 * _LEAST_PERIOD:
        return None
    moving = _bridged(x[start:end])
    stride = 1 + len(moving) // _THINNED
    proposed = [_sharpened(moving, stride * period, stride) for period in _periods(moving[::stride])]
    candidates = [
        cycles for period in dict.fromkeys(proposed) if (cycles := _extent(x, period, start, end)) is not None
    ]
    # Twice the period repeats as well, and a piece of the motion may by itself: the shortest that covers most of it.
    longest = max((cycles.period * cycles.count for cycles in candidates), default=0)
    covering = [cycles for cycles in candidates if cycles.period * cycles.count > _MOST * longest]
    return min(covering, key=lambda cycles: cycles.period, default=None)


def _normalised(motion: Floats) -> Floats:
    """The joints that move, centred and with range 1."""
    columns = []
    for column in motion.T:
        known = column[np.isfinite(column)]
        if len(known) and np.ptp(known) > 0:
            columns.append((column - known.mean()) / np.ptp(known))
    return np.column_stack(columns) if columns else np.empty((len(motion), 0))


def _bridged(x: Floats) -> Floats:
    """`x` (n, dof) with straight lines over its gaps."""
    index = np.arange(len(x))
    known = np.isfinite(x)
    return np.column_stack([np.interp(index, index[k], column[k]) for column, k in zip(x.T, known.T, strict=True)])


def _moving_range(x: Floats) -> tuple[int, int]:
    """The part of `x` between rest at its beginning and rest at its end."""
    known = np.flatnonzero(np.isfinite(x).all(axis=1) & (x.shape[1] > 0))
    if not len(known):
        return 0, 0
    from_start = np.flatnonzero((np.abs(x - x[known[0]]) > _TOLERANCE).any(axis=1))
    from_end = np.flatnonzero((np.abs(x - x[known[-1]]) > _TOLERANCE).any(axis=1))
    return max(int(from_start[0]) - 1, 0), min(int(from_end[-1]) + 2, len(x))


def _periods(x: Floats) -> list[int]:
    """Lags at which `x` (n, dof) resembles itself, the shortest of the best ones first."""
    difference = _difference(x)
    ordinary = float(np.median(difference))
    lags = np.arange(1, len(difference) - 1)
    minimum = (difference[lags] <= difference[lags - 1]) & (difference[lags] < difference[lags + 1])
    lags = lags[minimum & (difference[lags] < _ALIKE * ordinary)]
    if not len(lags):
        return []
    good = lags[difference[lags] <= difference[lags].min() + _NEARLY * ordinary]
    return [int(lag) for lag in good[:_CANDIDATES]]


def _difference(x: Floats) -> Floats:
    """(lags,) mean square of x(t + lag) - x(t) over all joints, for every lag, by way of the autocorrelation."""
    from scipy.fft import irfft, next_fast_len, rfft

    n = len(x)
    size = next_fast_len(2 * n, real=True)
    spectrum = rfft(x, size, axis=0)
    correlation = irfft((spectrum * spectrum.conj()).real.sum(axis=1), size)[: int(_FARTHEST * n)]
    energy = np.concatenate([[0.0], np.cumsum((x**2).sum(axis=1))])
    lags = np.arange(len(correlation))
    pairs = n - lags
    mean: Floats = (energy[pairs] + energy[n] - energy[lags] - 2 * correlation) / pairs
    return np.maximum(mean, 0)


def _sharpened(x: Floats, period: int, reach: int) -> int:
    """The period near `period` at which a quarter of the motion repeats best; the rest may be something else."""
    reach = max(2 * reach, int(_SHARPEN * period))
    # Between these steps the period is found by going downhill.
    step = 1 + reach // _STEPS
    lags = np.arange(max(period - reach, _LEAST_PERIOD), min(period + reach, len(x) - 2) + 1, step)
    rows = np.linspace(0, len(x) - 1 - lags[-1], _LOOKS).astype(np.int64)
    worst = [np.quantile(np.abs(x[rows + lag] - x[rows]).max(axis=1), 0.25) for lag in lags]
    return int(lags[np.argmin(worst)])


def _extent(x: Floats, period: int, start: int, end: int) -> Cycles | None:
    """How far the motion, which is at rest but from `start` to `end`, repeats with about this period, if it does."""
    low = max(start - period, 0)
    x = x[low : end + period]
    first, length = _longest(_mismatch(x, period) <= _TOLERANCE)
    if length < period // 2:
        return None
    inner = slice(first + length // 4, first + length - length // 4)
    period = _refined(x, period, inner)
    mismatch = _mismatch(x, period)
    # Exact repetitions end sharply, noisy ones do not: look again with the tolerance that this motion keeps.
    tolerance = min(_MARGIN * float(np.quantile(mismatch[inner], 0.99)) + _EXACT, _TOLERANCE)
    first, length = _longest(mismatch <= tolerance)
    count = (length + period) // period
    if count < 2 or np.nanmax(np.ptp(_bridged(x[first : first + length]), axis=0)) < 10 * _TOLERANCE:
        return None
    return Cycles(low + first, period, count)


def _mismatch(x: Floats, period: int) -> Floats:
    """(n - period,) how far from itself a period later the motion is, in the joint where it is farthest.

    Where that is not known, nothing speaks against a repetition.
    """
    worst: Floats = np.nan_to_num(np.abs(x[period:] - x[:-period])).max(axis=1)
    return worst


def _refined(x: Floats, period: int, inner: slice) -> int:
    """The period near `period` at which the samples `inner` repeat best."""

    rows = np.arange(inner.start, inner.stop, 1 + (inner.stop - inner.start) // _LOOKS)

    def mean(lag: int) -> float:
        return float(np.nan_to_num(np.abs(x[rows + lag] - x[rows])).max(axis=1).mean())

    while True:
        near = [lag for lag in (period, period - 1, period + 1) if _LEAST_PERIOD <= lag < len(x) - inner.stop]
        best = min(near, key=mean)
        if best == period:
            return period
        period = best


def _longest(true: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[int, int]:
    """First index and length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], true, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return 0, 0
    longest = int(np.argmax(ends - starts))
    return int(starts[longest]), int(ends[longest] - starts[longest])
