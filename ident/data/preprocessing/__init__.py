"""From samples to motion and torque fit for identification. One method is one file here, named as users type it.

A method's module holds `prepare(samples, cutoff) -> Prepared`; the cut-off [Hz] is None for the method's own choice.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from ident import plugins
from ident.data.cutoff import Cutoff
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from ident.filters import convolve
from recordings.recording import Floats, Ints

Preprocess = Callable[[Samples, float | None], "Preprocessed"]
Filter = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Preprocessed:
    """Motion and torque of one recording. NaN marks what is not known: gaps, ends, and what a filter made of them."""

    motion: Motion
    """n instants: what regressor columns are computed from, before `condition`."""
    instants: Ints
    """(n,) which samples these are."""
    condition: Filter
    """Filters and decimates columns (n, ...) computed from the motion as the torque was: (m, ...)."""
    torque: Floats
    """(m, dof) conditioned torque [N m]."""
    sensitivity: Floats
    """(m, dof) noise of the conditioned torque per noise of the equally conditioned voltage [N m/V]."""
    decimation: int
    """One conditioned sample for so many of the instants."""
    half_width: int | None
    """So many instants to either side have a say in a conditioned sample; None: all instants have."""
    rate: float
    """Conditioned samples per second [Hz]."""
    bandwidth: float
    """Highest frequency that is left, -3 dB, zero-phase [Hz]."""
    cutoff: Cutoff | None = None
    """How the bandwidth was chosen; None where the method has no choice."""


def load(name: str) -> Preprocess:
    """The method `name`. Raises BadInput where there is none."""
    return cast(Preprocess, plugins.load(__name__, name).prepare)


def sensitivity(slope: Floats, taps: Floats, step: int = 1) -> Floats:
    """`Prepared.sensitivity` (m, dof) of a filter with `taps`, from `Samples.slope` (n, dof).

    Where noise samples are alike and independent, the variance of their filtered sum adds up with the squares of the
    taps; so the mean of slope^2 is taken with them.
    """
    power = taps**2
    mean: Floats = np.sqrt(np.maximum(convolve(slope**2, power / power.sum(), step), 0.0))
    return mean
