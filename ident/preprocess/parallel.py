"""Parallel filtering: torque and regressor columns go through the same zero-phase low-pass, then are decimated.

Because both sides of the equation pass the same linear filter, its shape does not bias the parameters. What is not
linear in the motion needs care before it: derivatives and reversal instants are taken from a position that is
filtered so lightly that the motion is untouched (the same sgn from the analysis filter's output looks like
Stribeck friction), and sgn is averaged over the sample in which the joint reverses.
"""

import numpy as np

from ident import signals
from ident.motion import Motion
from ident.preprocess import Prepared
from recordings.errors import BadInput
from recordings.recording import Floats

DEFAULT_CUTOFF = 30.0
"""[Hz]; a tenth of the rate where that is lower."""


def prepare(position: Floats, torque: Floats, rate: float, cutoff: float | None) -> Prepared:
    """Filter `position` (n, dof) [rad] lightly for the motion, and `torque` (n, dof) [N m] at `cutoff` [Hz].

    Raises:
        BadInput: the cut-off is not within reach of the recording's rate.
    """
    if cutoff is None:
        cutoff = min(DEFAULT_CUTOFF, rate / 10)
    if not 0 < cutoff <= rate / 5:
        raise BadInput(
            f"a cut-off above 0 and up to a fifth of the rate ({rate / 5:g} Hz) expected, {cutoff:g} Hz found; "
            "lower it or record faster"
        )
    motion = _motion(position, rate, min(3 * cutoff, rate / 4))
    taps = signals.low_pass(cutoff, rate)
    # Past twice the cut-off the filter leaves less than a thousandth: a quarter of the new rate loses nothing.
    step = max(1, int(rate // (4 * cutoff)))
    conditioned = signals.convolve(torque, taps, step)
    return Prepared(motion, conditioned, np.isfinite(conditioned), taps, step, rate / step, cutoff)


def _motion(position: Floats, rate: float, cutoff: float) -> Motion:
    smooth = signals.convolve(position, signals.low_pass(cutoff, rate))
    velocity = signals.first_derivative(smooth, rate)
    acceleration = signals.second_derivative(smooth, rate)
    return Motion(smooth, velocity, acceleration, signals.mean_sign(velocity))
