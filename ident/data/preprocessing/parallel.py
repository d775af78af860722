"""Parallel filtering: torque and regressor columns pass the same zero-phase low-pass and are then decimated.

As both sides of the equation pass the same linear filter, its shape does not bias the parameters. Columns that are
nonlinear in the motion are computed before it, from a position that is filtered too lightly to change the motion.
(The sgn of a velocity behind the analysis filter would look like Stribeck friction.) At reversals, sgn is averaged
over the sample.
"""

from functools import partial

import numpy as np

from ident.basics import filters
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed, sensitivity
from ident.data.samples import Samples
from ident.dynamics.motion import Motion


def prepare(samples: Samples, cutoff: Cutoff) -> Preprocessed:
    """Filter the position lightly for the motion, and the torque at the `cutoff`."""
    rate = samples.rate
    taps = filters.low_pass(cutoff.hz, rate)
    # Above twice the cut-off less than a thousandth passes the filter, so a rate of four times the cut-off suffices.
    step = max(1, int(rate // (4 * cutoff.hz)))
    return Preprocessed(
        motion=_motion(samples, min(3 * cutoff.hz, rate / 4)),
        instants=np.arange(len(samples.position)),
        condition=partial(filters.convolve, taps=taps, step=step),
        torque=filters.convolve(samples.torque, taps, step),
        sensitivity=sensitivity(samples.slope, taps, step),
        decimation=step,
        half_width=len(taps) // 2,
        rate=rate / step,
        bandwidth=cutoff.hz,
        cutoff=cutoff,
    )


def _motion(samples: Samples, cutoff: float) -> Motion:
    """Differentiate the position after a low-pass at `cutoff` [Hz]."""
    rate, window = samples.rate, samples.window
    smooth = filters.convolve(samples.position, filters.low_pass(cutoff, rate))
    velocity = filters.first_derivative(smooth, rate)
    acceleration = filters.second_derivative(smooth, rate)
    return Motion(smooth, velocity, acceleration, filters.mean_sign(velocity, window * rate), window)
