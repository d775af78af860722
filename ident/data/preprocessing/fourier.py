"""Fourier differentiation: a periodic motion is a Fourier series, which is differentiated exactly.

The series spans all whole cycles together. Torque, motion and columns pass an ideal low-pass without transition band
or end effects. Differences between cycles are kept, as the fundamental period is the duration of all cycles.
"""

from functools import partial

import numpy as np

from ident.basics import filters
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints

_MOTION_BANDWIDTH_RATIO = 3.0
"""Ratio of the motion's bandwidth to the cut-off, for columns that are nonlinear in the motion."""


def prepare(samples: Samples, cutoff: Cutoff) -> Preprocessed:
    """Differentiate all whole cycles as one Fourier series, up to the `cutoff`.

    Raises:
        BadInput: no whole cycles, or gaps in the cycles.
    """
    instants = whole_cycles(samples).ravel()
    position, torque, slope = (signal[instants] for signal in (samples.position, samples.torque, samples.slope))
    if not np.isfinite([position, torque]).all():
        raise BadInput(
            "cycles without gaps expected for Fourier differentiation, gaps found; choose cycle_average or parallel"
        )
    return of_one_period(position, torque, slope, instants, samples, cutoff)


def whole_cycles(samples: Samples) -> Ints:
    """Indices (c, p) of the samples of the c cycles.

    Raises:
        BadInput: there are no cycles, or they differ in length, or they are not consecutive.
    """
    cycles = [np.flatnonzero(samples.repeat == number) for number in range(int(samples.repeat.max()) + 1)]
    lengths = {len(cycle) for cycle in cycles}
    if not cycles or len(lengths) > 1 or (np.diff(np.concatenate(cycles)) != 1).any():
        raise BadInput(
            "whole cycles of one length, one after the other, expected for Fourier differentiation, "
            f"cycles of {', '.join(map(str, sorted(lengths))) or 'no'} samples found; choose parallel"
        )
    return np.stack(cycles)


def of_one_period(
    position: Floats, torque: Floats, slope: Floats, instants: Ints, samples: Samples, cutoff: Cutoff
) -> Preprocessed:
    """Motion and torque from gapless signals (n, dof) that span one period of `samples`."""
    rate, window = samples.rate, samples.window
    low_pass = partial(_low_pass, cutoff=cutoff.hz, rate=rate)
    smooth, velocity, acceleration = _derivatives(position, rate, _MOTION_BANDWIDTH_RATIO * cutoff.hz)
    extended = np.concatenate([velocity[-1:], velocity, velocity[:1]])
    return Preprocessed(
        motion=Motion(smooth, velocity, acceleration, filters.mean_sign(extended, window * rate)[1:-1], window),
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
    """Remove the harmonics of `x` (n, ...) above `cutoff` [Hz]. A column that contains NaN becomes NaN."""
    spectrum = np.fft.rfft(x, axis=0)
    spectrum[np.fft.rfftfreq(len(x), 1 / rate) > cutoff] = 0
    return np.fft.irfft(spectrum, len(x), axis=0)


def _derivatives(position: Floats, rate: float, highest: float) -> tuple[Floats, Floats, Floats]:
    """Fourier series of `position` (n, dof) up to `highest` [Hz], with its first and second derivative."""
    frequency = np.fft.rfftfreq(len(position), 1 / rate)[:, None]
    spectrum = np.where(frequency <= min(highest, 0.45 * rate), np.fft.rfft(position, axis=0), 0)
    omega = 2j * np.pi * frequency
    value, first, second = (np.fft.irfft(spectrum * omega**k, len(position), axis=0) for k in range(3))
    return value, first, second
