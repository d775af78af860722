"""Sine waves over an angle or over time in the residual of one joint: periodograms and least squares."""

from collections.abc import Sequence
from dataclasses import dataclass
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
_STEPS = 4
"""Gauss-Newton steps of a wave number."""
MIN_SAMPLES = 64
"""Training samples and test samples below which no wave is searched, and a part of the samples is none by itself."""


class JointSignal:
    """The residual of one joint in all recordings, end to end, with the angle and the time of each sample."""

    def __init__(self, bands: Sequence[HighBand], joint: int) -> None:
        self.bands = bands
        self.angle = np.concatenate([band.position[:, joint] for band in bands])
        self.velocity = np.nan_to_num(np.concatenate([band.velocity[:, joint] for band in bands]))
        self.time = np.concatenate([band.time for band in bands])
        self.residual = np.concatenate([band.residual[:, joint] for band in bands])
        self.recording = np.repeat(np.arange(len(bands)), [len(band.time) for band in bands])
        known = np.isfinite(self.residual)
        self.train = np.concatenate([band.train[:, joint] for band in bands]) & known
        self.test = np.concatenate([band.test[:, joint] for band in bands]) & known
        self.torque_rms = float(np.sqrt(np.nanmean(np.concatenate([b.torque[:, joint] for b in bands]) ** 2)))
        speed = np.abs(self.velocity)[self.train]
        self.speed = float(speed @ speed / speed.sum()) if speed.any() else 0.0

    @property
    def highest_frequency(self) -> float:
        """Of the band of all recordings [Hz]."""
        return min(band.highest for band in self.bands)

    @property
    def low(self) -> float:
        """Lower end of the band [Hz]."""
        return max(band.low for band in self.bands)

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

    @cached_property
    def over_angle(self) -> "Carrier":
        """Waves over the angle; amplitude and phase are linear in the speed, in each recording and direction."""
        speed = np.abs(self.velocity) / (self.speed or 1.0)
        factors = np.stack([np.ones_like(speed)], axis=1)
        part = 2 * self.recording + (self.velocity > 0)
        return Carrier(self, np.nan_to_num(self.angle), factors, part, self.train, (self.velocity > 0).astype(int))

    @cached_property
    def over_time(self) -> "Carrier":
        """Waves over time, each with an amplitude and a phase in each recording that has training rows."""
        known = np.isin(self.recording, self.recording[self.train])
        none = np.zeros_like(self.recording)
        return Carrier(self, self.time, known[:, None].astype(float), self.recording, self.train, none)


@dataclass(frozen=True, eq=False)
class Carrier:
    """Waves over one coordinate, with amplitude and phase of their own in each part of the rows."""

    signal: JointSignal
    coordinate: Floats
    """(n,) angle [rad or m] or time [s]."""
    factors: Floats
    """(n, c) of sine and cosine."""
    part: Ints
    """(n,) number of the part of each sample."""
    train: Bools
    """(n,)"""
    wider: Ints
    """(n,) number of the parts' union that stands for a part without training rows."""

    @cached_property
    def centred(self) -> Floats:
        """(n,) the coordinate from its middle."""
        return self.coordinate - float(self.coordinate[self.train].mean())

    @cached_property
    def cell(self) -> float:
        """Resolution of wave numbers."""
        return 2 * np.pi / max(float(np.ptp(self.coordinate[self.train])), 1e-9)

    @cached_property
    def parts(self) -> list[tuple[Bools, Bools]]:
        """(n,) samples of each part, and (n,) training rows that are fitted for it."""
        parts = []
        for number in np.unique(self.part):
            here = self.part == number
            fitted = here & self.train
            if fitted.sum() < MIN_SAMPLES:
                fitted = np.isin(self.wider, self.wider[here]) & self.train
            parts.append((here, fitted))
        return parts

    def columns(self, number: float) -> Floats:
        """(n, 2 c) waves of one wave number, above the low-pass."""
        return self.signal.above(self._times_factors(wave(self.centred, number)))

    def coefficients(self, columns: Floats, target: Floats) -> Floats:
        """(n, c) coefficients of `columns` (n, c) for the `target` (n,), the same in all of a part."""
        coefficients = np.zeros_like(columns)
        for here, fitted in self.parts:
            coefficients[here] = least_squares(columns[fitted], target[fitted])
        return coefficients

    def fitted(self, columns: Floats, target: Floats) -> Floats:
        """(n,) what `columns` (n, c) explain of the `target` (n,)."""
        explained: Floats = np.sum(columns * self.coefficients(columns, target), axis=1)
        return explained

    def slope(self, number: float, rest: Floats) -> tuple[Floats, Floats]:
        """(n,) derivative of the wave in `rest` (n,) by its wave number, and (n,) what the wave leaves.

        Both without what amplitude and phase explain.
        """
        columns = self.columns(number)
        coefficients = self.coefficients(columns, rest)
        sine, cosine = wave(self.centred, number).T
        turned = self._times_factors(np.stack([cosine, -sine], axis=1))
        slope = self.signal.above((self.centred * np.sum(turned * coefficients, axis=1))[:, None])[:, 0]
        left = rest - np.sum(columns * coefficients, axis=1)
        return np.where(self.train, slope - self.fitted(columns, slope), 0.0), np.where(self.train, left, 0.0)

    def _times_factors(self, waves: Floats) -> Floats:
        product: Floats = (waves[:, :, None] * self.factors[:, None, :]).reshape(len(waves), -1)
        return product

    def refined(self, number: float, rest: Floats) -> float:
        """The wave number that explains most of `rest`, by Gauss-Newton steps within a resolution cell."""
        start = number
        for _ in range(_STEPS):
            slope, left = self.slope(number, rest)
            step = float(slope @ left) / max(float(slope @ slope), 1e-300)
            number = float(np.clip(number + step, start - self.cell / 2, start + self.cell / 2))
        return number

    def power(self, rest: Floats, grid: Floats) -> tuple[Floats, Floats]:
        """(f,) periodogram of `rest` (n,) on the `grid` (f,), and (f,) the noise in it per degree of freedom."""
        from scipy.stats import chi2

        parts = [np.isin(self.wider, number) & self.train for number in np.unique(self.wider)]
        parts = [rows for rows in parts if rows.sum() > MIN_SAMPLES]
        power = np.sum([periodogram(self.coordinate[rows], rest[rows], grid) for rows in parts], axis=0)
        blocks = np.array_split(power, max(len(power) // _WINDOW, 1))
        centres = np.cumsum([0, *(len(block) for block in blocks[:-1])]) + _WINDOW / 2
        medians = [float(np.median(block)) / chi2.median(2 * len(parts)) for block in blocks]
        return power, np.interp(np.arange(len(power)), centres, medians)

    def peaks(self, rest: Floats, grid: Floats, excluded: Bools) -> list[float]:
        """Wave numbers of the highest peaks of a periodogram: of all, and above their neighbourhood.

        The highest of all may hide in its own leakage, which raises the level around it; a small one, beside a
        resonance.
        """
        if len(grid) < _WINDOW:
            return []
        power, noise = self.power(rest, grid)
        ratio = power / np.maximum(noise, 1e-12 * power.max())
        peaks = np.flatnonzero((power >= np.roll(power, 1)) & (power >= np.roll(power, -1)) & ~excluded)
        best = [*peaks[np.argsort(-power[peaks])][:1], *peaks[np.argsort(-ratio[peaks])][:_CANDIDATES]]
        numbers: list[float] = grid[list(dict.fromkeys(best))].tolist()
        return numbers

    def is_significant(self, number: float, reduction: float, rest: Floats, grid: Floats) -> bool:
        """Whether a wave reduces the sum of squares more than chance, measured by what it leaves around it.

        reduction: of the sum of squares of the training rows; rest: (n,) what is left.
        """
        from scipy.stats import chi2

        if len(grid) < 2:
            return False
        columns = 2 * self.factors.shape[1] * len(np.unique(self.part[self.train]))
        noise = np.interp(number, grid, self.power(rest, grid)[1])
        return bool(reduction > noise * chi2.isf(FALSE_ALARM * OVERSAMPLING / len(grid), columns))


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


def wave_numbers(coordinate: Floats, highest: float, lowest: float = 0.0) -> Floats:
    """The grid of a periodogram over a `coordinate` (n,): from one period over all of it, or from `lowest`."""
    cell = 2 * np.pi / max(float(np.ptp(coordinate)), 1e-9)
    return np.arange(max(lowest, cell), highest, cell / OVERSAMPLING)
