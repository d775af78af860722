"""Torque ripple over the angle of the motor."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

LOWEST, HIGHEST = 6.0, 500.0
"""Lines per turn that are looked for; slower ones are gravity and springs."""
_BEST = 6


def columns(view: EffectInputs, shapes: Shapes) -> Floats:
    """sin N q and cos N q (n, dof, 2)."""
    angle = shapes["N"] * view.motion.position
    both: Floats = np.stack([np.sin(angle), np.cos(angle)], axis=2)
    return both


def suggest(view: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """The lines that stand out of the periodogram of the `residual` (n, dof) over the angle, all joints together."""
    travel = float(np.nanmax(np.nanmax(view.motion.position, axis=0) - np.nanmin(view.motion.position, axis=0)))
    lines = np.arange(LOWEST, HIGHEST, 1.0 / travel)
    power = np.zeros(len(lines))
    for position, left in zip(view.motion.position.T, residual.T, strict=True):
        known = np.isfinite(position) & np.isfinite(left)
        if known.any():
            power += _periodogram(position[known], left[known] - left[known].mean(), lines)
    peaks = np.flatnonzero((power >= np.roll(power, 1)) & (power >= np.roll(power, -1)))
    best = peaks[np.argsort(-power[peaks])][:_BEST]
    return [{"N": float(lines[i])} for i in best]


def _periodogram(position: Floats, residual: Floats, lines: Floats) -> Floats:
    """Fall of the sum of squares, about, by each of the `lines` (l,)."""
    bins = np.linspace(position.min(), position.max(), 8 * len(lines))
    step = bins[1] - bins[0]
    place = np.rint((position - bins[0]) / step).astype(int)
    gathered = np.bincount(place, residual, len(bins))
    size = 1 << int(np.ceil(np.log2(4 * len(bins))))
    spectrum = np.fft.rfft(gathered, size)
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
            implausible_bound="lower",  # what is slower still is a curve over the angle, of which the wave is a piece
        ),
    ),
    suggest=suggest,
    repeated=True,
    columns=columns,
)
