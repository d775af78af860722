"""Cycle averaging: the mean cycle of a motion that repeats, by Fourier differentiation.

Of c cycles, noise that differs between them shrinks by the root of c, and a sample lost in some is known from the
others. What changes from cycle to cycle is averaged away: to see it, choose another method.
"""

import numpy as np

from ident.data import cutoff as choice
from ident.data.preprocessing import Preprocessed, fourier
from ident.data.samples import Samples
from recordings.errors import BadInput
from recordings.recording import Floats, Ints


def prepare(samples: Samples, cutoff: float | None) -> Preprocessed:
    """Differentiate the mean cycle as a Fourier series, up to `cutoff` [Hz] or one read from the spectra.

    Raises:
        BadInput: no whole cycles, a phase that no cycle knows, or a cut-off that is not within reach of the rate.
    """
    chosen = choice.given_or_chosen(cutoff, samples)
    cycles = fourier.whole_cycles(samples)
    position, torque, slope = (_mean(signal, cycles) for signal in (samples.position, samples.torque, samples.slope))
    return fourier.of_one_period(position, torque, slope, cycles[0], samples.rate, chosen)


def _mean(signal: Floats, cycles: Ints) -> Floats:
    """(p, dof) mean of `signal` (n, dof) over `cycles` (c, p)."""
    values = signal[cycles]
    known = np.isfinite(values).sum(axis=0)
    if (known == 0).any():
        raise BadInput("each phase of the motion known in one cycle at least expected, gaps found; choose parallel")
    mean: Floats = np.nansum(values, axis=0) / known
    return mean
