"""Preprocessing methods: samples to motion and torque for identification. Each method is a module of that name.

The module defines `prepare(samples, cutoff) -> Preprocessed`; the cut-off is None for a method that has none.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from ident.basics import plugins
from ident.basics.filters import convolve
from ident.data.cutoff import Cutoff
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Ints

Preprocess = Callable[[Samples, Cutoff | None], "Preprocessed"]
Filter = Callable[[Floats], Floats]

WITHOUT_CUTOFF = frozenset({"central"})
"""Methods that have no cut-off."""


@dataclass(frozen=True, eq=False)
class Preprocessed:
    """Motion and torque of one recording. NaN marks gaps, ends and samples whose filter window reaches them."""

    motion: Motion
    """n instants: the motion from which regressor columns are computed before `condition`."""
    instants: Ints
    """(n,) indices of the samples."""
    condition: Filter
    """Filters and decimates columns (n, ...) in the same way as the torque: (m, ...)."""
    torque: Floats
    """(m, dof) conditioned torque [N m]."""
    sensitivity: Floats
    """(m, dof) noise of the conditioned torque per noise of the voltage conditioned in the same way [N m/V]."""
    decimation: int
    """Instants per conditioned sample."""
    half_width: int | None
    """Half-width of the filter in instants; None: every instant influences every conditioned sample."""
    rate: float
    """Conditioned samples per second [Hz]."""
    bandwidth: float
    """Bandwidth (-3 dB) of the zero-phase filter [Hz]."""
    cutoff: Cutoff | None = None
    """How the bandwidth was chosen; None if the method has no cut-off."""


def load(name: str) -> Preprocess:
    """Load the method `name`.

    Raises:
        BadInput: there is no such method.
    """
    return cast(Preprocess, plugins.load(__name__, name).prepare)


def sensitivity(slope: Floats, taps: Floats, step: int = 1) -> Floats:
    """`Preprocessed.sensitivity` (m, dof) of a filter with `taps`, from `Samples.slope` (n, dof).

    For independent, identically distributed noise, the variance of the filtered sum weights slope^2 with the squared
    taps.
    """
    power = taps**2
    return np.sqrt(np.maximum(convolve(slope**2, power / power.sum(), step), 0.0))
