"""Spectral densities by Welch's method.

As scipy.signal.welch and csd with Hann's window, of which a test has the numbers: loading scipy.signal takes longer
than all spectra of a diagnosis.
"""

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Floats


def transforms(signal: Floats, segment: int, *, centred: bool) -> NDArray[np.complex128]:
    """Fourier transforms (segments, m) of half-overlapping segments of `signal` (n,), `segment` samples each.

    centred: whether the mean of each segment is subtracted.
    """
    segments = np.lib.stride_tricks.sliding_window_view(signal, segment)[:: segment - segment // 2]
    if centred:
        segments = segments - segments.mean(axis=1, keepdims=True)
    return np.fft.rfft(segments * _window(segment))


def density(a: NDArray[np.complex128], b: NDArray[np.complex128], segment: int, rate: float) -> Floats:
    """Real part (m,) of the one-sided cross-spectral density [1/Hz] of signals with the `transforms` a and b.

    rate: of the signals [Hz]. The power spectral density of one signal where b is a.
    """
    real: Floats = (a.conj() * b).real.mean(axis=0) / (rate * (_window(segment) ** 2).sum())
    real[1 : (segment + 1) // 2] *= 2  # all but 0 Hz and half the rate
    return real


def _window(length: int) -> Floats:
    """Hann's window, which is periodic."""
    return 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
