"""Sine waves over an angle or over time in the residual of one joint: periodograms and least squares."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ident.diagnosis.ripple.high_band import HighBand
from ident.dynamics.effects.periodogram import periodogram
from recordings.recording import Bools, Floats, Ints

FALSE_ALARM = 1e-6
"""Probability that the highest peak of noise exceeds the threshold."""
BLOCK_PERIODS = 3.0
"""Length of a block that counts as independent, in periods of the low-pass."""
OVERSAMPLING = 4
"""Points of a periodogram per resolution cell."""
_WINDOW = 24 * OVERSAMPLING
"""Points of a periodogram over which the noise level around a peak is taken."""
_CANDIDATES = 4
"""Number of peaks that are tried in turn."""
_FAST = 0.98
"""Quantile of the speed up to which a wave has to stay within the band."""
_STEPS = 4
"""Gauss-Newton steps of a wave number."""


class JointSignal:
    """The residual of one joint in all recordings, end to end, with the angle and the time of each sample."""

    def __init__(self, bands: Sequence[HighBand], joint: int) -> None:
        self.bands, self._joint = bands, joint
        self.angle = np.concatenate([band.position[:, joint] for band in bands])
        self.time = np.concatenate([band.time for band in bands])
        self.residual = np.concatenate([band.residual[:, joint] for band in bands])
        self.recording = np.repeat(np.arange(len(bands)), [len(band.time) for band in bands])
        known = np.isfinite(self.residual)
        self.train = np.concatenate([band.train[:, joint] for band in bands]) & known
        self.test = np.concatenate([band.test[:, joint] for band in bands]) & known
        self.torque_rms = float(np.sqrt(np.nanmean(np.concatenate([b.torque[:, joint] for b in bands]) ** 2)))
        speed = np.abs(np.concatenate([band.velocity[:, joint] for band in bands]))[self.train]
        self.speed = float(np.quantile(speed, _FAST)) if len(speed) else 0.0

    @property
    def highest_frequency(self) -> float:
        """Of the band of all recordings [Hz]."""
        return min(band.highest for band in self.bands)

    @property
    def low(self) -> float:
        """Lower end of the band [Hz]."""
        return max(band.low for band in self.bands)

    def of_recording(self, index: int) -> "JointSignal":
        """The signal in one of the recordings, of which some samples are known."""
        return JointSignal([self.bands[index]], self._joint)

    @cached_property
    def blocks(self) -> Ints:
        """(n,) number of the block of each sample."""
        length = BLOCK_PERIODS / self.low
        number = np.floor(self.time / length).astype(int)
        blocks: Ints = number - number.min() + self.recording * (np.ptp(number) + 1)
        return blocks

    def above(self, columns: Floats) -> Floats:
        """`columns` (n, c) above the low-pass; 0 where unknown."""
        ends = np.cumsum([len(band.time) for band in self.bands])[:-1]
        parts = zip(self.bands, np.split(columns, ends), strict=True)
        high: Floats = np.nan_to_num(np.concatenate([band.above(part) for band, part in parts]))
        return high

    def refined(self, coordinate: Floats, wave_number: float, cell: float, rest: Floats, rows: Bools) -> float:
        """The wave number that explains most of `rest` in `rows`, by Gauss-Newton steps within a resolution cell."""
        start, coordinate = wave_number, coordinate - float(coordinate[rows].mean())
        for _ in range(_STEPS):
            columns = wave(coordinate, wave_number)
            above = self.above(columns)[rows]
            sine, cosine = least_squares(above, rest[rows])
            derivative = self.above(slope(coordinate, columns, sine, cosine)[:, None])[rows]
            step = least_squares(np.concatenate([above, derivative], axis=1), rest[rows])[-1]
            wave_number = float(np.clip(wave_number + step, start - cell / 2, start + cell / 2))
        return wave_number


def least_squares(matrix: Floats, signal: Floats) -> Floats:
    """(c,) coefficients of the columns of `matrix` (n, c) for the `signal` (n,); c is small."""
    gram = matrix.T @ matrix
    size = np.sqrt(np.diag(gram))
    size[size == 0] = 1.0
    coefficients = np.linalg.lstsq(gram / np.outer(size, size), matrix.T @ signal / size, rcond=1e-12)[0]
    scaled: Floats = coefficients / size
    return scaled


def wave(coordinate: Floats, wave_number: float) -> Floats:
    """(n, 2) sine and cosine."""
    phase = wave_number * coordinate
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


def slope(coordinate: Floats, columns: Floats, sine: float, cosine: float) -> Floats:
    """(n,) derivative of a wave with respect to its wave number, from its sine and cosine `columns` (n, 2)."""
    derivative: Floats = coordinate * (sine * columns[:, 1] - cosine * columns[:, 0])
    return derivative


def wave_numbers(coordinate: Floats, highest: float, lowest: float = 0.0) -> Floats:
    """The grid of a periodogram over a `coordinate` (n,): from one period over all of it, or from `lowest`."""
    cell = 2 * np.pi / max(float(np.ptp(coordinate)), 1e-9)
    return np.arange(max(lowest, cell), highest, cell / OVERSAMPLING)


def highest_peaks(coordinate: Floats, rest: Floats, grid: Floats) -> list[float]:
    """Wave numbers of the highest peaks of a periodogram: of all, and above their neighbourhood.

    The highest of all may hide in its own leakage, which raises the level around it; a small one, beside a resonance.
    """
    if len(grid) < _WINDOW:
        return []
    power = periodogram(coordinate, rest, grid)
    peaks = np.flatnonzero((power >= np.roll(power, 1)) & (power >= np.roll(power, -1)))
    ratio = power / np.maximum(_level(power), 1e-12 * power.max())
    clear = peaks[ratio[peaks] > _threshold(grid) / 2]
    best = [*peaks[np.argsort(-power[peaks])][:1], *clear[np.argsort(-ratio[clear])][:_CANDIDATES]]
    wave_numbers: list[float] = grid[list(dict.fromkeys(best))].tolist()
    return wave_numbers


def is_significant(wave_number: float, reduction: float, coordinate: Floats, rest: Floats, grid: Floats) -> bool:
    """Whether a wave reduces the sum of squares more than chance, measured by what it leaves around it.

    reduction: of the sum of squares; rest: (n,) what is left.
    """
    if len(grid) < 2:
        return False
    level = np.interp(wave_number, grid, _level(periodogram(coordinate, rest, grid)))
    return bool(reduction > level * _threshold(grid))


def _threshold(grid: Floats) -> float:
    """Ratio of the highest peak of noise on a `grid` (f,) to its level, exceeded with the probability FALSE_ALARM."""
    return float(np.log(len(grid) / OVERSAMPLING / FALSE_ALARM))


def _level(power: Floats) -> Floats:
    """(f,) noise level around each entry of a periodogram (f,), from medians."""
    blocks = np.array_split(power, max(len(power) // _WINDOW, 1))
    centres = np.cumsum([0, *(len(block) for block in blocks[:-1])]) + _WINDOW / 2
    # The median of an exponential distribution is ln 2 of its mean.
    medians = [float(np.median(block)) / np.log(2) for block in blocks]
    level: Floats = np.interp(np.arange(len(power)), centres, medians)
    return level
