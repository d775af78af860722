"""Find vibrations that are not synchronous with the motion: lines in the spectrum of the differences between cycles.

Vibrations of a fan, a pump or the floor differ from cycle to cycle and would be counted as noise; but the spectrum of
noise has no lines. A line is narrow, and lasts from the beginning of the recording to its end: the transient of an
event has peaks in its spectrum, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.threads import in_threads
from ident.data.cycle_differences import cycle_differences, deviation_within_groups
from ident.data.prepared_recording import PreparedRecording
from recordings.recording import Floats

MIN_FREQUENCY = 1.0
"""Lowest frequency of a vibration [Hz]."""
FALSE_ALARM = 1e-6
"""Probability that the highest peak of noise exceeds the threshold."""
_COLOURED = 1.5
"""Factor on the threshold, as coloured noise has higher peaks than white noise."""
_PADDING = 4
"""Zero-padding factor of the spectrum, so that no line falls between two frequencies."""
_MAX_WIDTH = 2.0
"""Largest width of a line at half of its height, in units of the resolution of the recording."""
_MAX_WANDER = 0.02
"""Share of its frequency by which a vibration may wander."""
_SEGMENTS = 6
"""Number of segments of a recording in all of which, but for one, a vibration lasts."""
_MIN_LASTING = 0.25
"""Smallest share of its mean square that a vibration has in such a segment: half of the amplitude."""
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

    def strongest(joint: int) -> SpectralLine | None:
        pairs = zip(recordings, residuals, strict=True)
        candidates = [line for data, residual in pairs if (line := _strongest_line(data, residual[:, joint]))]
        return max(candidates, key=lambda line: line.mean_square, default=None)

    return tuple(in_threads(strongest, range(residuals[0].shape[1])))


def _strongest_line(prepared: PreparedRecording, residual: Floats) -> SpectralLine | None:
    """Find the strongest line of one joint in one recording."""
    deviation, correction = _deviation(prepared, residual, residual)
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
    if power[peak] / noise < _COLOURED * np.log(independent / FALSE_ALARM):
        return None
    duration = count / prepared.rate
    if _half_width(power, peak) * frequency[1] > max(_MAX_WIDTH / duration, _MAX_WANDER * frequency[peak]):
        return None
    if not _lasts(prepared, residual, float(frequency[peak])):
        return None
    # A sine of amplitude A gives a peak of A^2 count / 4, and has the mean square A^2 / 2.
    return SpectralLine(float(frequency[peak]), float(2 * (power[peak] - noise) / count) * correction)


def _half_width(power: Floats, peak: int) -> int:
    """Width of a `peak` of the spectrum `power` at half of its height, in entries."""
    low = np.flatnonzero(power < power[peak] / 2)
    after = int(np.searchsorted(low, peak))
    end = int(low[after]) if after < len(low) else len(power)
    return end - (int(low[after - 1]) if after else -1) - 1


def _lasts(prepared: PreparedRecording, residual: Floats, frequency: float) -> bool:
    """Whether `residual` (m,) contains a vibration of this `frequency` in all segments of the recording, but one."""
    time = prepared.time
    angle = np.where(np.isfinite(residual), 2 * np.pi * frequency * time, np.nan)
    deviation, cosine, sine = (
        _deviation(prepared, signal, residual)[0] for signal in (residual, np.cos(angle), np.sin(angle))
    )
    known = np.isfinite(deviation)
    segment = np.floor(_SEGMENTS * (time - time[0]) / (time[-1] - time[0]) * (1 - 1e-9)).astype(int)[known]
    products = [np.bincount(segment, wave[known] * deviation[known], _SEGMENTS) for wave in (cosine, sine)]
    energy = np.bincount(segment, (cosine**2 + sine**2)[known], _SEGMENTS)
    occupied = energy > 0
    squares = (products[0] ** 2 + products[1] ** 2)[occupied] / energy[occupied] ** 2
    return int((squares < _MIN_LASTING * squares.mean()).sum()) <= 1


def _deviation(prepared: PreparedRecording, x: Floats, residual: Floats) -> tuple[Floats, float]:
    """Deviation of `x` (m,) from the mean of the cycles between which no event disturbs the `residual` (m,).

    Returns also the factor that corrects its variance for the subtracted means: C / (C - 1) for C equal cycles.
    """
    inside = (prepared.repeat >= 0) & np.isfinite(residual)
    numbers, cycle = np.unique(prepared.repeat[inside], return_inverse=True)
    if len(numbers) < 2:
        return np.where(np.isfinite(residual), x - np.nanmean(x), np.nan), 1.0
    phase = np.rint(prepared.phase[inside] * prepared.rate).astype(int)
    present, place = np.unique(phase, return_inverse=True)
    table, values = np.full((2, len(numbers), len(present)), np.nan)
    table[cycle, place], values[cycle, place] = residual[inside], x[inside]
    deviation = np.full(len(x), np.nan)
    differences = cycle_differences(table)
    if differences is None:
        return deviation, 1.0
    within, groups = deviation_within_groups(values, differences)
    deviation[inside] = within[cycle, place]
    count = int(np.isfinite(deviation).sum())
    return deviation, count / max(count - groups, 1)


def _noise_level(power: Floats, frequency: Floats) -> Floats:
    """Level of the noise from the running median, which is ln 2 of the mean for an exponential distribution."""
    from scipy.ndimage import median_filter

    width = max(int(2 * _AROUND / (frequency[1] - frequency[0])), 3)
    return median_filter(power, size=width, mode="nearest") / np.log(2)
