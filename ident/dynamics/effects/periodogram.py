"""Periodogram of a signal over an uneven coordinate: an angle, or time with gaps."""

import numpy as np

from recordings.recording import Floats

_BINS = 8
"""Bins per period of the highest frequency: its amplitude falls by 3 % at most."""
MAX_PHASE = 2e6
"""Largest product of span and frequency [rad]; it bounds memory and time."""
_CREEPING = 0.01
"""Share of the highest speed that counts as moving."""
_IN_BAND_SHARE = 0.25
"""Share of the moving time at which a wave lies within the bandwidth; others are searched above it."""


def highest_in_band(speed: Floats, bandwidth: float) -> float:
    """Return the highest wave number that a low-pass of `bandwidth` [Hz] leaves in a share of the moving time.

    speed: (n,) or (n, dof), not negative [rad/s or m/s]; NaN is skipped.
    """
    moving = speed[speed > _CREEPING * np.nanmax(speed)]
    return 2 * np.pi * bandwidth / float(np.quantile(moving, _IN_BAND_SHARE))


def highest_peaks(coordinate: Floats, signal: Floats, frequencies: Floats, count: int) -> list[float]:
    """Return the frequencies of the `count` highest peaks in the sum of the joints' periodograms, the highest first.

    coordinate, signal: (n, dof), NaN where unknown; frequencies: (f,) as in `periodogram`; none where there are none.
    """
    power = np.zeros(len(frequencies))
    for position, values in zip(coordinate.T, signal.T, strict=True):
        known = np.isfinite(position) & np.isfinite(values)
        if known.any() and len(frequencies):
            power += periodogram(position[known], values[known] - values[known].mean(), frequencies)
    peaks = np.flatnonzero((power >= np.roll(power, 1)) & (power >= np.roll(power, -1)))
    return frequencies[peaks[np.argsort(-power[peaks])][:count]].tolist()


def periodogram(coordinate: Floats, signal: Floats, frequencies: Floats) -> Floats:
    """Compute by how much a wave of each frequency reduces the sum of squares of a signal: (f,).

    A discrete Fourier transform of the signal in narrow bins, for many samples all over the coordinate.

    coordinate, signal: (n,) without NaN; frequencies: (f,) [rad per unit of the coordinate], increasing.
    """
    width = 2 * np.pi / (_BINS * frequencies[-1])
    index = np.rint((coordinate - coordinate.min()) / width).astype(int)
    binned = np.bincount(index, signal)
    size = 1 << int(np.ceil(np.log2(4 * len(binned))))
    spectrum = np.fft.rfft(binned, size)
    grid = 2 * np.pi * np.arange(len(spectrum)) / (size * width)
    return np.interp(frequencies, grid, np.abs(spectrum) ** 2) * (2 / len(signal))
