"""Fourier differentiation: a motion that repeats is a Fourier series, whose derivatives are exact.

Over all whole cycles together, torque, motion and columns lose everything above the cut-off at once, by a filter that
has neither slope nor ends. What does not repeat is kept: harmonics of all the cycles' duration together are there.
"""

from functools import partial

import numpy as np

from ident import filters
from ident.data import cutoff as choice
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints

_FINER = 3.0
"""The motion keeps harmonics up to so many times the cut-off, for columns that are not linear in it."""


def prepare(samples: Samples, cutoff: float | None) -> Preprocessed:
    """Differentiate all whole cycles as one Fourier series, up to `cutoff` [Hz] or one read from the spectra.

    Raises:
        BadInput: no whole cycles, gaps in them, or a cut-off that is not within reach of the rate.
    """
    chosen = choice.given_or_chosen(cutoff, samples)
    instants = whole_cycles(samples).ravel()
    position, torque, slope = (signal[instants] for signal in (samples.position, samples.torque, samples.slope))
    if not np.isfinite([position, torque]).all():
        raise BadInput(
            "cycles without gaps expected for Fourier differentiation, gaps found; choose cycle_average or parallel"
        )
    return of_one_period(position, torque, slope, instants, samples.rate, chosen)


def whole_cycles(samples: Samples) -> Ints:
    """(c, p) the samples of each of the c repetitions.

    Raises:
        BadInput: there are none, or they do not follow each other.
    """
    found = [np.flatnonzero(samples.repeat == number) for number in range(int(samples.repeat.max()) + 1)]
    lengths = {len(one) for one in found}
    if not found or len(lengths) > 1 or (np.diff(np.concatenate(found)) != 1).any():
        raise BadInput(
            "whole cycles of one length, one after the other, expected for Fourier differentiation, "
            f"cycles of {', '.join(map(str, sorted(lengths))) or 'no'} samples found; choose parallel"
        )
    return np.stack(found)


def of_one_period(
    position: Floats, torque: Floats, slope: Floats, instants: Ints, rate: float, cutoff: Cutoff
) -> Preprocessed:
    """Motion and torque of signals (n, dof) that are one period of a periodic motion, without gaps."""
    low_pass = partial(_low_pass, cutoff=cutoff.hz, rate=rate)
    smooth, velocity, acceleration = _derivatives(position, rate, _FINER * cutoff.hz)
    around = np.concatenate([velocity[-1:], velocity, velocity[:1]])
    return Preprocessed(
        motion=Motion(smooth, velocity, acceleration, filters.mean_sign(around)[1:-1]),
        instants=instants,
        condition=low_pass,
        torque=low_pass(torque),
        sensitivity=np.sqrt(np.maximum(low_pass(slope**2), 0.0)),
        decimation=1,
        half_width=None,
        rate=rate,
        bandwidth=cutoff.hz,
        cutoff=cutoff,
    )


def _low_pass(x: Floats, cutoff: float, rate: float) -> Floats:
    """`x` (n, ...) without its harmonics above `cutoff` [Hz]. NaN anywhere in a column spoils the column."""
    spectrum = np.fft.rfft(x, axis=0)
    spectrum[np.fft.rfftfreq(len(x), 1 / rate) > cutoff] = 0
    return np.fft.irfft(spectrum, len(x), axis=0)


def _derivatives(position: Floats, rate: float, highest: float) -> tuple[Floats, Floats, Floats]:
    """The Fourier series of `position` (n, dof) up to `highest` [Hz], and its first and second derivative."""
    frequency = np.fft.rfftfreq(len(position), 1 / rate)[:, None]
    spectrum = np.where(frequency <= min(highest, 0.45 * rate), np.fft.rfft(position, axis=0), 0)
    omega = 2j * np.pi * frequency
    value, first, second = (np.fft.irfft(spectrum * omega**k, len(position), axis=0) for k in range(3))
    return value, first, second
