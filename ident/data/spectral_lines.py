"""Vibrations of a frequency of their own: lines in the spectrum of what differs between repetitions of the motion.

A fan, a pump or a shaking floor does not keep time with the motion, so it differs from one repetition to the next and
would pass for noise; but noise has no lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.dataset import Dataset
from recordings.recording import Floats

MIN_FREQUENCY = 1.0
"""Slower than this is no vibration [Hz]."""
_CHANCE = 1e-6
"""Probability that the highest peak of noise is as high."""
_STEEP = 1.5
"""Noise whose level changes with the frequency has higher peaks than one that is level."""
_PADDING = 4
"""Of the spectrum, so that no line falls between two of its frequencies."""
_AROUND = 2.0
"""Noise is what the spectrum is within this distance of a line [Hz]."""


@dataclass(frozen=True)
class SpectralLine:
    """A vibration of one joint."""

    frequency: float
    """[Hz]"""
    mean_square: float
    """[(N m)^2]"""


def strongest_lines(datasets: Sequence[Dataset], residuals: Sequence[Floats]) -> tuple[SpectralLine | None, ...]:
    """The strongest line of each joint in `residuals` (m, dof), if it stands out of the noise in any recording."""
    dof = residuals[0].shape[1]
    found = []
    for joint in range(dof):
        pairs = zip(datasets, residuals, strict=True)
        of_each = [one for data, left in pairs if (one := _line(data, left[:, joint]))]
        found.append(max(of_each, key=lambda one: one.mean_square, default=None))
    return tuple(found)


def _line(dataset: Dataset, residual: Floats) -> SpectralLine | None:
    """Of one joint of one recording."""
    differing, kept = _differing(dataset, residual)
    known = np.isfinite(differing)
    count = int(known.sum())
    if count < 64:
        return None
    size = _PADDING * (1 << int(np.ceil(np.log2(len(differing)))))
    power = np.abs(np.fft.rfft(np.where(known, differing, 0.0), size)) ** 2 / count
    frequency = np.fft.rfftfreq(size, 1 / dataset.rate).astype(np.float64)
    inside = (frequency > MIN_FREQUENCY) & (frequency < dataset.bandwidth)
    if not inside.any() or not power[inside].any():
        return None
    # What was taken off lies at the motion's own frequencies, and makes the level seem lower.
    level = np.maximum(kept * _smooth(power, frequency), 1e-9 * power[inside].max())
    peak = int(np.argmax(np.where(inside, power / level, 0.0)))
    noise = level[peak]
    independent = dataset.bandwidth * count / dataset.rate
    if power[peak] / noise < _STEEP * np.log(independent / _CHANCE):
        return None
    # A sine of amplitude A gives a peak of A^2 count / 4, and has the mean square A^2 / 2.
    return SpectralLine(float(frequency[peak]), float(2 * (power[peak] - noise) / count) * kept)


def _differing(dataset: Dataset, residual: Floats) -> tuple[Floats, float]:
    """`residual` (m,) less its mean over the repetitions at each phase; and the factor that makes up for that."""
    inside = (dataset.repeat >= 0) & np.isfinite(residual)
    cycles = len(np.unique(dataset.repeat[inside]))
    if cycles < 2:
        return np.where(np.isfinite(residual), residual - np.nanmean(residual), np.nan), 1.0
    place = np.rint(dataset.phase[inside] * dataset.rate).astype(int)
    count = np.bincount(place)
    mean = np.bincount(place, residual[inside]) / np.maximum(count, 1)
    left = np.full(len(residual), np.nan)
    left[inside] = residual[inside] - mean[place]
    return left, cycles / (cycles - 1)


def _smooth(power: Floats, frequency: Floats) -> Floats:
    """Level of the noise, from the median around each frequency; that of an exponential distribution is ln 2."""
    from scipy.ndimage import median_filter

    width = max(int(2 * _AROUND / (frequency[1] - frequency[0])), 3)
    level: Floats = median_filter(power, size=width, mode="nearest") / np.log(2)
    return level
