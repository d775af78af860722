"""Find vibrations that are not synchronous with the motion: lines in the spectrum of the differences between cycles.

Vibrations of a fan, a pump or the floor differ from cycle to cycle and would be counted as noise; but the spectrum of
noise has no lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from recordings.recording import Floats

MIN_FREQUENCY = 1.0
"""Lowest frequency of a vibration [Hz]."""
_FALSE_ALARM = 1e-6
"""Probability that the highest peak of noise exceeds the threshold."""
_COLOURED = 1.5
"""Factor on the threshold, as coloured noise has higher peaks than white noise."""
_PADDING = 4
"""Zero-padding factor of the spectrum, so that no line falls between two frequencies."""
_AROUND = 2.0
"""Half-width of the window for the noise level around a frequency [Hz]."""


@dataclass(frozen=True)
class SpectralLine:
    """A vibration of one joint."""

    frequency: float
    """[Hz]"""
    mean_square: float
    """[(N m)^2]"""


def strongest_lines(
    recordings: Sequence[PreparedRecording], residuals: Sequence[Floats]
) -> tuple[SpectralLine | None, ...]:
    """Find the strongest line of each joint in `residuals` (m, dof) over all recordings; None if not significant."""
    dof = residuals[0].shape[1]
    strongest = []
    for joint in range(dof):
        pairs = zip(recordings, residuals, strict=True)
        candidates = [line for data, residual in pairs if (line := _strongest_line(data, residual[:, joint]))]
        strongest.append(max(candidates, key=lambda line: line.mean_square, default=None))
    return tuple(strongest)


def _strongest_line(prepared: PreparedRecording, residual: Floats) -> SpectralLine | None:
    """Find the strongest line of one joint in one recording."""
    deviation, correction = _deviation(prepared, residual)
    known = np.isfinite(deviation)
    count = int(known.sum())
    if count < 64:
        return None
    size = _PADDING * (1 << int(np.ceil(np.log2(len(deviation)))))
    power = np.abs(np.fft.rfft(np.where(known, deviation, 0.0), size)) ** 2 / count
    frequency = np.fft.rfftfreq(size, 1 / prepared.rate).astype(np.float64)
    inside = (frequency > MIN_FREQUENCY) & (frequency < prepared.bandwidth)
    if not inside.any() or not power[inside].any():
        return None
    # The subtracted mean cycle lowers the level at the harmonics of the motion.
    level = np.maximum(correction * _noise_level(power, frequency), 1e-9 * power[inside].max())
    peak = int(np.argmax(np.where(inside, power / level, 0.0)))
    noise = level[peak]
    independent = prepared.bandwidth * count / prepared.rate
    if power[peak] / noise < _COLOURED * np.log(independent / _FALSE_ALARM):
        return None
    # A sine of amplitude A gives a peak of A^2 count / 4, and has the mean square A^2 / 2.
    return SpectralLine(float(frequency[peak]), float(2 * (power[peak] - noise) / count) * correction)


def _deviation(prepared: PreparedRecording, residual: Floats) -> tuple[Floats, float]:
    """Deviation of `residual` (m,) from its mean cycle, and the factor C / (C - 1) that corrects its variance."""
    inside = (prepared.repeat >= 0) & np.isfinite(residual)
    cycles = len(np.unique(prepared.repeat[inside]))
    if cycles < 2:
        return np.where(np.isfinite(residual), residual - np.nanmean(residual), np.nan), 1.0
    phase = np.rint(prepared.phase[inside] * prepared.rate).astype(int)
    count = np.bincount(phase)
    mean = np.bincount(phase, residual[inside]) / np.maximum(count, 1)
    deviation = np.full(len(residual), np.nan)
    deviation[inside] = residual[inside] - mean[phase]
    return deviation, cycles / (cycles - 1)


def _noise_level(power: Floats, frequency: Floats) -> Floats:
    """Level of the noise from the running median, which is ln 2 of the mean for an exponential distribution."""
    from scipy.ndimage import median_filter

    width = max(int(2 * _AROUND / (frequency[1] - frequency[0])), 3)
    level: Floats = median_filter(power, size=width, mode="nearest") / np.log(2)
    return level
