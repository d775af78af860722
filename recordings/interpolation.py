"""Linear interpolation of sampled signals that may have gaps."""

import numpy as np

from recordings.recording import Floats, Ints


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
