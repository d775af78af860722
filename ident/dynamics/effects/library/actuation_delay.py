"""Time delay between reported voltage and torque."""

from functools import lru_cache

import numpy as np
from scipy.ndimage import convolve1d

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from recordings.recording import Floats

_REACH = 12
"""Half length of the interpolation filter, in samples."""


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Report the torque (n, dof, ...) of delta later."""
    shifted = [_ahead(torque[:, joint], delta * inputs.rate) for joint, delta in enumerate(values["delta"])]
    return np.stack(shifted, axis=1)


def _ahead(x: Floats, instants: float) -> Floats:
    """Advance `x` (n, ...) by a fractional number of `instants` with a windowed sinc; NaN beyond the ends."""
    if instants == 0:
        return x
    whole = int(np.floor(instants))
    ends = np.full((_REACH + abs(whole), *x.shape[1:]), np.nan)
    sums: Floats = convolve1d(np.concatenate([ends, x, ends]), _taps(instants - whole), axis=0)
    return sums[len(ends) + whole :][: len(x)]


@lru_cache(maxsize=16)
def _taps(fraction: float) -> Floats:
    """Taps (2 reach + 1,) that advance by a `fraction` of an instant, the last one first."""
    distance = np.arange(-_REACH, _REACH + 1) - fraction
    taps = np.sinc(distance) * np.i0(6.0 * np.sqrt(np.maximum(1 - (distance / (_REACH + 1)) ** 2, 0)))
    return (taps / taps.sum())[::-1]


effect = Signal(
    sentence="Torque and position, as they are reported, are not of one time: delta > 0, the torque comes later than "
    "its report or the position is measured late; delta < 0, the report of the torque is late.",
    size="{delta}",
    symptom="The residual follows the rate of change of the torque.",
    causes="filters and cycle times in the amplifier or encoder, values of different cycles in one message",
    remedy="find out when the drive samples what it reports, and enter or compensate the delay",
    record="fast changes of the torque: high accelerations, and two motions of different speed",
    equation="reported(t) = torque(t + delta); delta < 0: a measurement delay",
    axis="acceleration",
    memory=True,
    parameters=(
        Quantity(
            name="delta",
            unit="s",
            meaning="torque after the drive signal",
            lower=-0.02,
            upper=0.02,
            usual=0.005,
            initial_guesses=(5e-4,),
        ),
    ),
    report=report,
    pointwise=False,
)
