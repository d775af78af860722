"""Savitzky-Golay filtering: a cubic fitted around each sample gives position, velocity and acceleration.

As in `parallel`, the motion is filtered lightly (a short window), and torque and columns pass the same smoothing
filter (a long window). The transition band is wider than that of `parallel`, so nothing is decimated.
"""

from functools import partial

import numpy as np

from ident.basics import filters
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed, sensitivity
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.recording import Floats

ORDER = 3
MOTION_CUTOFF_RATIO = 3.0
"""Ratio of the motion's cut-off to the torque's cut-off."""
_LENGTH_TIMES_CUTOFF = 1.07
"""A cubic fitted to a window of n samples attenuates by 3 dB at 1.07 / n of the rate."""


def prepare(samples: Samples, cutoff: Cutoff) -> Preprocessed:
    """Fit cubics with an attenuation of 3 dB at the `cutoff`."""
    rate = samples.rate
    position, velocity, acceleration = (
        filters.convolve(samples.position, taps(MOTION_CUTOFF_RATIO * cutoff.hz, rate, k)) for k in range(3)
    )
    smoothing = taps(cutoff.hz, rate)
    return Preprocessed(
        motion=Motion(
            position, velocity, acceleration, filters.mean_sign(velocity, samples.window * rate), samples.window
        ),
        instants=np.arange(len(position)),
        condition=partial(filters.convolve, taps=smoothing),
        torque=filters.convolve(samples.torque, smoothing),
        sensitivity=sensitivity(samples.slope, smoothing),
        decimation=1,
        half_width=len(smoothing) // 2,
        rate=rate,
        bandwidth=cutoff.hz,
        cutoff=cutoff,
    )


def taps(cutoff: float, rate: float, derivative: int = 0) -> Floats:
    """Taps of the filter that computes the `derivative` (0, 1 or 2) of the cubic at the centre of its window."""
    from scipy.signal import savgol_coeffs

    length = max(ORDER + 2, 2 * round((_LENGTH_TIMES_CUTOFF * rate / cutoff - 1) / 2) + 1)
    return savgol_coeffs(length, ORDER, deriv=derivative, delta=1 / rate)
