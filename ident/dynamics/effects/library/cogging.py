"""Torque ripple over the angle of the motor."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

LOWEST, HIGHEST = 6.0, 500.0
"""Range of the spectral lines that are suggested [1/turn]; gravity and springs are below it."""
_BEST = 6
"""Number of suggestions."""


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """sin N q and cos N q (n, dof, 2)."""
    angle = shapes["N"] * inputs.motion.position
    pair: Floats = np.stack([np.sin(angle), np.cos(angle)], axis=2)
    return pair


def suggest(inputs: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """Suggest the peaks of the periodogram of the `residual` (n, dof) over the angle, summed over all joints."""
    travel = float(np.nanmax(np.nanmax(inputs.motion.position, axis=0) - np.nanmin(inputs.motion.position, axis=0)))
    lines = np.arange(LOWEST, HIGHEST, 1.0 / travel)
    power = np.zeros(len(lines))
    for position, signal in zip(inputs.motion.position.T, residual.T, strict=True):
        known = np.isfinite(position) & np.isfinite(signal)
        if known.any():
            power += _periodogram(position[known], signal[known] - signal[known].mean(), lines)
    peaks = np.flatnonzero((power >= np.roll(power, 1)) & (power >= np.roll(power, -1)))
    best = peaks[np.argsort(-power[peaks])][:_BEST]
    return [{"N": float(lines[i])} for i in best]


def _periodogram(position: Floats, residual: Floats, lines: Floats) -> Floats:
    """Approximate reduction of the sum of squares by each of the `lines` (l,)."""
    bins = np.linspace(position.min(), position.max(), 8 * len(lines))
    step = bins[1] - bins[0]
    index = np.rint((position - bins[0]) / step).astype(int)
    binned = np.bincount(index, residual, len(bins))
    size = 1 << int(np.ceil(np.log2(4 * len(bins))))
    spectrum = np.fft.rfft(binned, size)
    frequency = 2 * np.pi * np.arange(len(spectrum)) / (size * step)
    power: Floats = np.interp(lines, frequency, np.abs(spectrum) ** 2) / len(position)
    return power


effect = Additive(
    sentence="The torque ripples with the angle of the motor.",
    symptom="The residual is a wave over the angle, the same in both directions, at any speed.",
    causes="magnets that hold on to the teeth of the stator, current sensors out of balance, teeth of a gear",
    remedy="choose skewed motors, recalibrate the drive's current sensors, or add the wave to the feed-forward",
    equation="a sin N q + b cos N q",
    axis="motor angle",
    coefficients=(
        Quantity(name="a", unit="{effort}", meaning="amplitude of the sine"),
        Quantity(name="b", unit="{effort}", meaning="amplitude of the cosine"),
    ),
    shapes=(
        Quantity(
            name="N",
            unit="1/turn",
            meaning="periods per turn of the joint",
            lower=LOWEST - 1,
            upper=2000.0,
            implausible_bound="lower",  # a slower wave cannot be told from a curve over the angle
        ),
    ),
    suggest=suggest,
    repeated=True,
    columns=columns,
)
