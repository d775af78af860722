"""The paper's preprocessing (Section 2): central differences on the raw angles, nothing filtered.

It amplifies the encoder's noise by 1/dt^2; it is here to reproduce the paper.
"""

import numpy as np

from ident.motion import Motion
from ident.preprocess import Prepared
from ident.signals import convolve
from recordings.errors import BadInput
from recordings.recording import Floats


def prepare(position: Floats, torque: Floats, rate: float, cutoff: float | None) -> Prepared:
    """Three-point differences of `position` (n, dof) [rad]; `torque` (n, dof) [N m] as it is.

    Raises:
        BadInput: a cut-off was given; this method has no filter.
    """
    if cutoff is not None:
        raise BadInput(
            f"no cut-off expected with central differences, {cutoff:g} Hz found; leave it out or choose parallel"
        )
    velocity = convolve(position, np.array([0.5, 0.0, -0.5]) * rate)
    acceleration = convolve(position, np.array([1.0, -2.0, 1.0]) * rate**2)
    motion = Motion(position, velocity, acceleration, np.sign(velocity))
    return Prepared(motion, torque, np.isfinite(torque), taps=np.ones(1), step=1, rate=rate, bandwidth=rate / 2)
