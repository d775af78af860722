"""Parallel filtering: torque and regressor columns pass the same zero-phase low-pass and are then decimated.

As both sides of the equation pass the same linear filter, its shape does not bias the parameters. Columns that are
nonlinear in the motion are computed before it, from a position that is filtered too lightly to change the motion.
(The sgn of a velocity behind the analysis filter would look like Stribeck friction.) At reversals, sgn is averaged
over the sample.
"""

from functools import partial

import numpy as np

from ident.basics import filters
from ident.data import cutoff as choice
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed, sensitivity
from ident.data.samples import Samples
from ident.dynamics.motion import Motion
from recordings.recording import Floats


def prepare(samples: Samples, cutoff: float | Cutoff | None) -> Preprocessed:
    """Filter the position lightly for the motion, and the torque at `cutoff` [Hz] or a cut-off chosen from the
    spectra.

    Raises:
        BadInput: the cut-off is too high for the recording's rate.
    """
    chosen = choice.given_or_chosen(cutoff, samples)
    rate = samples.rate
    taps = filters.low_pass(chosen.hz, rate)
    # Above twice the cut-off less than a thousandth passes the filter, so a rate of four times the cut-off suffices.
    step = max(1, int(rate // (4 * chosen.hz)))
    return Preprocessed(
        motion=motion(samples.position, rate, min(3 * chosen.hz, rate / 4)),
        instants=np.arange(len(samples.position)),
        condition=partial(filters.convolve, taps=taps, step=step),
        torque=filters.convolve(samples.torque, taps, step),
        sensitivity=sensitivity(samples.slope, taps, step),
        decimation=step,
        half_width=len(taps) // 2,
        rate=rate / step,
        bandwidth=chosen.hz,
        cutoff=chosen,
    )


def motion(position: Floats, rate: float, cutoff: float) -> Motion:
    """Differentiate `position` (n, dof) after a low-pass at `cutoff` [Hz]."""
    smooth = filters.convolve(position, filters.low_pass(cutoff, rate))
    velocity = filters.first_derivative(smooth, rate)
    acceleration = filters.second_derivative(smooth, rate)
    return Motion(smooth, velocity, acceleration, filters.mean_sign(velocity), 1 / rate)
