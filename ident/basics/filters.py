"""Zero-phase FIR filters and differentiation of signals with gaps.

All filters are symmetric and finite. An output is NaN exactly where the taps reach a gap (NaN) or an end of the
recording.
"""

from functools import lru_cache

import numpy as np

from recordings.recording import Bools, Floats

REACH = 1.5
"""Half-width of a low-pass, in periods of its cut-off."""
_STOPBAND = 6.0
"""Kaiser's beta: about 63 dB of attenuation."""

# Central differences of order eight: right halves of an odd and of an even stencil. At 30 Hz and 500 samples a
# second their error is below 1e-6; that of three-point differences is above 1 %.
_FIRST = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
_SECOND = (8 / 5, -1 / 5, 8 / 315, -1 / 560)


def convolve(x: Floats, taps: Floats, step: int = 1) -> Floats:
    """Convolve `x` (n, ...) along time with `taps`, centred on samples 0, step, 2 step, ...: (ceil(n / step), ...).

    The number of `taps` is odd. NaN where the taps reach a gap or an end.
    """
    from ident.basics.numba_cache import compiled  # numba takes time to load

    signals = np.array(x.reshape(len(x), -1).T, float, order="C")  # sums run over adjacent values
    sums = compiled(_sums, fastmath={"reassoc", "contract"})(signals, taps[::-1].copy(), step)
    return sums.reshape(len(sums), *x.shape[1:])


def _sums(signals: Floats, reversed_taps: Floats, step: int) -> Floats:
    """Compiled: sums (ceil(n / step), c) of `convolve` for `signals` (c, n)."""
    count, n = signals.shape
    length = len(reversed_taps)
    sums = np.full(((n + step - 1) // step, count), np.nan)
    for column in range(count):
        for row in range((length // 2 + step - 1) // step, len(sums)):
            first = row * step - length // 2
            if first + length > n:
                break
            window = signals[column, first : first + length]
            total = 0.0
            for i in range(length):
                total += reversed_taps[i] * window[i]
            sums[row, column] = total
    return sums


def contiguous_slices(known: Bools) -> list[slice]:
    """Return the slices of consecutive samples that are `known` (n,), in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    return [slice(int(first), int(end)) for first, end in zip(edges[::2], edges[1::2], strict=True)]


@lru_cache
def low_pass(cutoff: float, rate: float) -> Floats:
    """Compute the taps (read-only) of a low-pass with -3 dB at `cutoff` [Hz], for `rate` samples per second.

    A sinc with a Kaiser window, REACH to either side, with a gain of exactly one at 0 Hz.
    """
    from scipy.optimize import brentq

    half = int(np.ceil(REACH * rate / cutoff))
    at_cutoff = np.cos(2 * np.pi * cutoff / rate * np.arange(-half, half + 1))

    def excess(corner: float) -> float:
        return float(_windowed_sinc(corner / rate, half) @ at_cutoff - np.sqrt(0.5))

    taps = _windowed_sinc(brentq(excess, cutoff, min(2 * cutoff, rate / 2)) / rate, half)
    taps.flags.writeable = False
    return taps


def _windowed_sinc(corner: float, half: int) -> Floats:
    """Taps of a windowed sinc with the `corner` in cycles per sample."""
    taps = np.sinc(2 * corner * np.arange(-half, half + 1)) * np.kaiser(2 * half + 1, _STOPBAND)
    return taps / taps.sum()


def first_derivative(x: Floats, rate: float) -> Floats:
    """Compute the time derivative of `x` (n, ...) by central differences of order eight."""
    right = np.array(_FIRST)
    return convolve(x, np.concatenate([right[::-1], [0.0], -right]) * rate)


def second_derivative(x: Floats, rate: float) -> Floats:
    """Compute the second time derivative of `x` (n, ...) by central differences of order eight."""
    right = np.array(_SECOND)
    return convolve(x, np.concatenate([right[::-1], [-2 * right.sum()], right]) * rate**2)


def mean_sign(velocity: Floats, window: float = 1.0) -> Floats:
    """Average sgn of `velocity` (n, dof) over half a `window` [samples, at most 1] to either side of each instant.

    The velocity is interpolated linearly. Over a straight line from a to b the mean of sgn is (|b| - |a|) / (b - a),
    because sgn is the derivative of the absolute value.
    """
    rise = np.diff(velocity, axis=0) * (window / 2)
    unknown = np.full_like(velocity[:1], np.nan)
    before = _mean_sign_between(np.concatenate([unknown, velocity[1:] - rise]), velocity)
    after = _mean_sign_between(velocity, np.concatenate([velocity[:-1] + rise, unknown]))
    return (before + after) / 2


def _mean_sign_between(a: Floats, b: Floats) -> Floats:
    rise = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        mean: Floats = np.where(rise == 0, np.sign(a), (np.abs(b) - np.abs(a)) / rise)
    return mean
