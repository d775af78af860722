"""Savitzky-Golay: a cubic through each sample's neighbours gives position, velocity and acceleration at once.

As in `parallel`, the motion comes from a light filter (a short window); torque and columns are then smoothed alike,
by a long one. Cubics keep more of what is just above the cut-off than the low-pass of `parallel`, so nothing is
decimated.
"""

from functools import partial

import numpy as np

from ident import filters
from ident.data import cutoff as choice
from ident.data.preprocessing import Preprocessed, sensitivity
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.recording import Floats

ORDER = 3
LIGHTER = 3.0
"""The cut-off of the motion over that of the torque."""
_LENGTH_TIMES_CUTOFF = 1.07
"""Of cubics: a window of n samples is 3 dB down at 1.07 / n of the rate."""


def prepare(samples: Samples, cutoff: float | None) -> Preprocessed:
    """Fit cubics to windows that smooth by 3 dB at `cutoff` [Hz], or at one read from the spectra.

    Raises:
        BadInput: the cut-off is not within reach of the recording's rate.
    """
    chosen = choice.given_or_chosen(cutoff, samples)
    rate = samples.rate
    value, slope, bend = (filters.convolve(samples.position, taps(LIGHTER * chosen.hz, rate, k)) for k in range(3))
    smoothing = taps(chosen.hz, rate)
    return Preprocessed(
        motion=Motion(value, slope, bend, filters.mean_sign(slope)),
        instants=np.arange(len(value)),
        condition=partial(filters.convolve, taps=smoothing),
        torque=filters.convolve(samples.torque, smoothing),
        sensitivity=sensitivity(samples.slope, smoothing),
        decimation=1,
        half_width=len(smoothing) // 2,
        rate=rate,
        bandwidth=chosen.hz,
        cutoff=chosen,
    )


def taps(cutoff: float, rate: float, derivative: int = 0) -> Floats:
    """The filter that gives the `derivative` (0, 1 or 2) of the cubic at the middle of its window."""
    from scipy.signal import savgol_coeffs

    length = max(ORDER + 2, 2 * round((_LENGTH_TIMES_CUTOFF * rate / cutoff - 1) / 2) + 1)
    coefficients: Floats = savgol_coeffs(length, ORDER, deriv=derivative, delta=1 / rate)
    return coefficients
