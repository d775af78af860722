"""Cycle averaging: Fourier differentiation of the mean cycle of a repeated motion.

Averaging c cycles reduces noise by the square root of c and fills samples that are missing in some cycles. It also
removes changes from cycle to cycle; choose another method to see them.
"""

import numpy as np

from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed, fourier
from ident.data.samples import Samples
from recordings.errors import BadInput
from recordings.recording import Floats, Ints


def prepare(samples: Samples, cutoff: Cutoff) -> Preprocessed:
    """Differentiate the mean cycle as a Fourier series, up to the `cutoff`.

    Raises:
        BadInput: no whole cycles, or a phase without samples in any cycle.
    """
    cycles = fourier.whole_cycles(samples)
    position, torque, slope = (_mean(signal, cycles) for signal in (samples.position, samples.torque, samples.slope))
    return fourier.of_one_period(position, torque, slope, cycles[0], samples, cutoff)


def _mean(signal: Floats, cycles: Ints) -> Floats:
    """Mean (p, dof) of `signal` (n, dof) over `cycles` (c, p)."""
    values = signal[cycles]
    known = np.isfinite(values).sum(axis=0)
    if (known == 0).any():
        raise BadInput("samples at every phase in at least one cycle expected, gaps found; choose parallel")
    return np.nansum(values, axis=0) / known
