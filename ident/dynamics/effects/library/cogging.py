"""Torque ripple over the angle of the motor."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity
from ident.dynamics.effects.periodogram import MAX_PHASE, highest_in_band, highest_peaks
from recordings.recording import Floats

LOWEST, HIGHEST = 6.0, 3000.0
"""Range of the spectral lines that are suggested [1/turn]; gravity and springs are below it."""
_BEST = 6
"""Number of suggestions."""


def suggest(inputs: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """Suggest the peaks of the periodogram of the `residual` (n, dof) over the angle, summed over all joints."""
    position = inputs.motion.position
    travel = float(np.nanmax(np.nanmax(position, axis=0) - np.nanmin(position, axis=0)))
    lowest = max(LOWEST, 2 * np.pi / travel)  # a longer period is a curve over the angle, no ripple
    highest = highest_in_band(np.abs(inputs.motion.velocity), inputs.bandwidth)
    lines = np.arange(lowest, min(HIGHEST, MAX_PHASE / travel, highest), 1.0 / travel)
    return [{"N": line} for line in highest_peaks(position, residual, lines, _BEST)]


effect = Additive(
    sentence="The torque ripples with the angle of the motor.",
    size="{norm}, {N:n} times per {turn}",
    symptom="The residual is a wave over the angle, the same in both directions, at any speed.",
    causes="magnets that hold on to the teeth of the stator, current sensors out of balance, teeth of a gear",
    remedy="choose skewed motors, recalibrate the drive's current sensors, or add the wave to the feed-forward",
    record="slow strokes at a constant speed over the whole travel, sampled at least ten times in a period",
    axis="motor angle",
    formula=lambda q, N: (np.sin(N * q), np.cos(N * q)),
    parameters=(
        Quantity(name="a", unit="{effort}", meaning="amplitude of the sine"),
        Quantity(name="b", unit="{effort}", meaning="amplitude of the cosine"),
    ),
    shapes=(
        Quantity(
            name="N",
            unit="1/{turn}",
            meaning="periods per turn of the joint",
            lower=LOWEST - 1,
            upper=HIGHEST,
            implausible_bound="lower",  # a slower wave cannot be told from a curve over the angle
        ),
    ),
    suggest=suggest,
    repeated=True,
)
