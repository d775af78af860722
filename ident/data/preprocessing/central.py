"""The paper's preprocessing (Section 2): central differences on the raw angles, nothing filtered.

This amplifies encoder noise by 1/dt^2. The method exists to reproduce the paper.
"""

import numpy as np

from ident.basics.filters import convolve
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.errors import BadInput


def prepare(samples: Samples, cutoff: Cutoff | None) -> Preprocessed:
    """Differentiate the position by three-point differences; the torque is unchanged.

    Raises:
        BadInput: a cut-off was given; this method has no filter.
    """
    if cutoff is not None:
        raise BadInput("no cut-off expected with central differences, one found: leave it out or choose parallel")
    velocity = convolve(samples.position, np.array([0.5, 0.0, -0.5]) * samples.rate)
    acceleration = convolve(samples.position, np.array([1.0, -2.0, 1.0]) * samples.rate**2)
    return Preprocessed(
        motion=Motion(samples.position, velocity, acceleration, np.sign(velocity)),
        instants=np.arange(len(velocity)),
        condition=lambda x: x,
        torque=samples.torque,
        sensitivity=samples.slope,
        decimation=1,
        half_width=0,
        rate=samples.rate,
        bandwidth=samples.rate / 2,
    )
