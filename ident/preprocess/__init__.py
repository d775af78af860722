"""From measured position and torque to motion and torque fit for identification. One method is one file here.

A method's module holds `prepare(position, torque, rate, cutoff) -> Prepared`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np

from ident import discovery
from ident.motion import Motion
from ident.signals import convolve
from recordings.recording import Floats

Method = Callable[[Floats, Floats, float, float | None], "Prepared"]
"""(position (n, dof) [rad], torque (n, dof) [N m], rate [Hz], cut-off [Hz] or None for the method's own)."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """Motion and torque of one recording. NaN marks what is not known: gaps, ends, and what a filter made of them."""

    motion: Motion
    """At every sample of the recording: what regressor columns are computed from, before `condition`."""
    torque: Floats
    """(m, dof) conditioned torque [N m]."""
    mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    """(m, dof) True where the conditioned torque is known."""
    taps: Floats
    """The filter that torque and columns go through alike."""
    step: int
    """One conditioned sample for so many recorded ones."""
    rate: float
    """Conditioned samples per second [Hz]."""
    bandwidth: float
    """Highest frequency that is left, -3 dB, zero-phase [Hz]."""

    def condition(self, x: Floats) -> Floats:
        """Filter and decimate `x` (n, ...) as the torque was: (m, ...)."""
        return convolve(x, self.taps, self.step)

    def sensitivity(self, slope: Floats) -> Floats:
        """(m, dof) noise of the conditioned torque per noise of the equally conditioned voltage [N m/V].

        `slope` (n, dof) [N m/V] is the torque map's derivative. Where noise samples are alike and independent, the
        variance of their filtered sum adds up with the squares of the taps; so slope^2 is averaged with these.
        """
        power = self.taps**2
        mean: Floats = np.sqrt(np.maximum(convolve(slope**2, power / power.sum(), self.step), 0.0))
        return mean


def load(name: str) -> Method:
    """The method `name`. Raises BadInput where there is none."""
    return cast(Method, discovery.load("preprocess", name).prepare)
