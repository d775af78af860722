"""Linear interpolation of sampled signals that may have gaps."""

import numpy as np

from recordings.recording import Floats, Ints

MAX_GAP = 2.5
"""Samples further apart than so many steps have a gap between them, in which nothing is known."""


def interpolate_within_gaps(instants: Floats, time: Floats | Ints, signal: Floats) -> Floats:
    """Interpolate `signal` (n,); NaN in gaps, and more than a step before its first or after its last sample."""
    known = np.isfinite(time)
    time = time[known]
    if not len(time):
        return np.full(len(instants), np.nan)
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    right = np.searchsorted(time, instants).clip(0, len(time) - 1)
    gap = (time[right] != instants) & (time[right] - time[np.maximum(right - 1, 0)] > MAX_GAP * step)
    outside = (instants < time[0] - step) | (instants > time[-1] + step)
    return np.where(gap | outside, np.nan, np.interp(instants, time, signal[known]))


def interpolate(instants: Floats, time: Floats | Ints, signal: Floats) -> Floats:
    """Interpolate `signal` (n,), sampled at `time` (n,), linearly at the `instants` (m,), in the unit of `time`.

    Samples that are NaN are passed over. The signal is held before its first and after its last sample; it is NaN
    where there is none.
    """
    known = np.isfinite(time) & np.isfinite(signal)
    return np.interp(instants, time[known], signal[known]) if known.any() else np.full(len(instants), np.nan)


def interpolate_columns(instants: Floats, time: Floats | Ints, values: Floats) -> Floats:
    """Interpolate every column of `values` (n, k) in the same way: (m, k)."""
    return np.column_stack([interpolate(instants, time, column) for column in values.T])
