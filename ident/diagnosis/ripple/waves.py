"""Sine waves over an angle or over time in the residual of one joint: periodograms and least squares."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ident.basics.statistics import least_squares
from ident.data.spectral_lines import FALSE_ALARM
from ident.diagnosis.ripple.high_band import HighBand
from ident.diagnosis.search.selection import WIDTH
from ident.dynamics.effects.periodogram import periodogram
from recordings.recording import Bools, Floats, Ints

OVERSAMPLING = 4
"""Points of a periodogram per resolution cell."""
_WINDOW = 24 * OVERSAMPLING
"""Points of a periodogram over which the noise level around a peak is taken."""
_STEPS = 4
"""Gauss-Newton steps of a wave number."""
MIN_SAMPLES = 64
"""Training samples and test samples below which no wave is searched, and a part of the samples is none by itself."""


@dataclass(frozen=True)
class Vibration:
    """A wave of one joint over time."""

    joint: int
    """From 0."""
    frequency: float
    """[Hz]"""
    amplitude: float
    """[N m]"""


class JointSignal:
    """The residual of one joint in all recordings, end to end, with the angle and the time of each sample."""

    def __init__(self, bands: Sequence[HighBand], joint: int) -> None:
        self.bands, self.joint = bands, joint
        self.angle = np.concatenate([band.motion.position[:, joint] for band in bands])
        self.velocity = np.nan_to_num(np.concatenate([band.motion.velocity[:, joint] for band in bands]))
        self.time = np.concatenate([band.prepared.instant_time for band in bands])
        self.residual = np.concatenate([band.residual[:, joint] for band in bands])
        self.recording = np.repeat(np.arange(len(bands)), [len(band.residual) for band in bands])
        known = np.isfinite(self.residual)
        self.train = np.concatenate([band.train[:, joint] for band in bands]) & known
        self.test = np.concatenate([band.test[:, joint] for band in bands]) & known
        self.torque_rms = float(
            np.sqrt(np.nanmean(np.concatenate([b.prepared.samples.torque[:, joint] for b in bands]) ** 2))
        )
        speed = np.abs(self.velocity)[self.train]
        self.speed = float(speed @ speed / speed.sum()) if speed.any() else 0.0

    @property
    def highest_frequency(self) -> float:
        """Of the band of all recordings [Hz]."""
        return min(band.highest for band in self.bands)

    @property
    def low(self) -> float:
        """Lower end of the band [Hz]."""
        return max(band.prepared.bandwidth for band in self.bands)

    def blocks(self, periods: float, low: float) -> Ints:
        """(n,) number of the block of each sample, which lasts so many `periods` of the frequency `low` [Hz]."""
        number = np.floor(self.time * low / periods).astype(int)
        return number - number.min() + self.recording * (np.ptp(number) + 1)

    def parts(self, x: NDArray[Any]) -> list[NDArray[Any]]:
        """The part of `x` (n, ...) in each recording."""
        return np.split(x, np.cumsum([len(band.residual) for band in self.bands])[:-1])

    def above(self, columns: Floats) -> Floats:
        """`columns` (n, c) above the low-pass; 0 where unknown."""
        parts = zip(self.bands, self.parts(columns), strict=True)
        return np.nan_to_num(np.concatenate([band.above(part) for band, part in parts]))

    def within(self, x: Floats, low: float, high: float) -> Floats:
        """The part between the frequencies `low` and `high` [Hz] of `x` (n,) above the low-pass."""
        return np.concatenate(
            [band.within(part, low, high) for band, part in zip(self.bands, self.parts(x), strict=True)]
        )

    def over_angle(self) -> "Carrier":
        """Waves over the angle: the drive delays and attenuates them, in each direction in another way."""
        forward = (self.velocity > 0).astype(int)
        return Carrier(self, np.nan_to_num(self.angle), 2 * self.recording + forward, forward)

    def over_time(self) -> "Carrier":
        """Waves over time: their phases in two recordings are unrelated."""
        return Carrier(self, self.time, self.recording, np.zeros_like(self.recording))


@dataclass(frozen=True, eq=False)
class Carrier:
    """Waves over one coordinate, with an amplitude and a phase in each part of the samples."""

    signal: JointSignal
    coordinate: Floats
    """(n,) angle [rad or m] or time [s]."""
    part: Ints
    """(n,) number of the part of each sample."""
    union: Ints
    """(n,) number of the parts that stand for a part without training rows: those of all recordings."""

    @cached_property
    def centred(self) -> Floats:
        """(n,) the coordinate from its middle."""
        return self.coordinate - float(self.coordinate[self.signal.train].mean())

    @cached_property
    def cell(self) -> float:
        """Resolution of wave numbers."""
        return 2 * np.pi / max(float(np.ptp(self.coordinate[self.signal.train])), 1e-9)

    @cached_property
    def parts(self) -> list[tuple[Bools, Bools]]:
        """(n,) samples of each part, and (n,) training rows that are fitted for it."""
        train = self.signal.train
        parts = [self.part == number for number in np.unique(self.part)]
        return [
            (
                here,
                here & train
                if (here & train).sum() >= MIN_SAMPLES
                else np.isin(self.union, self.union[here]) & train,
            )
            for here in parts
        ]

    def columns(self, number: float) -> Floats:
        """(n, 2) sine and cosine of one wave number above the low-pass."""
        return self.signal.above(wave(self.centred, number))

    def coefficients(self, columns: Floats, target: Floats) -> Floats:
        """(n, c) coefficients of `columns` (n, c) for the `target` (n,), the same in all of a part."""
        coefficients = np.zeros_like(columns)
        for here, fitted in self.parts:
            coefficients[here] = least_squares(columns[fitted], target[fitted])
        return coefficients

    def fitted(self, columns: Floats, target: Floats) -> Floats:
        """(n,) what `columns` (n, c) explain of the `target` (n,)."""
        return np.sum(columns * self.coefficients(columns, target), axis=1)

    def slope(self, number: float, target: Floats) -> tuple[Floats, Floats]:
        """(n,) derivative of the wave in the `target` (n,) by its wave number, and (n,) what the wave leaves.

        Both without what amplitude and phase explain, and zero outside of the training rows.
        """
        columns = self.columns(number)
        pairs = self.coefficients(columns, target)
        sine, cosine = wave(self.centred, number).T
        slope = self.signal.above((self.centred * (pairs[:, 0] * cosine - pairs[:, 1] * sine))[:, None])[:, 0]
        left, train = target - np.sum(columns * pairs, axis=1), self.signal.train
        return np.where(train, slope - self.fitted(columns, slope), 0.0), np.where(train, left, 0.0)

    def refined(self, number: float, rest: Floats) -> float:
        """The wave number that explains most of `rest`, by Gauss-Newton steps within a resolution cell."""
        start = number
        for _ in range(_STEPS):
            slope, left = self.slope(number, rest)
            step = float(slope @ left) / max(float(slope @ slope), float(np.finfo(float).tiny))
            number = float(np.clip(number + step, start - self.cell / 2, start + self.cell / 2))
        return number

    def power(self, rest: Floats, grid: Floats) -> tuple[Floats, Floats]:
        """(f,) periodogram of `rest` (n,) on the `grid` (f,), and (f,) the noise in it per degree of freedom."""
        from scipy.special import chdtri

        unions = [(self.union == number) & self.signal.train for number in np.unique(self.union)]
        parts = [rows for rows in unions if rows.sum() >= MIN_SAMPLES]
        power = np.sum([periodogram(self.coordinate[rows], rest[rows], grid) for rows in parts], axis=0)
        blocks = np.array_split(power, max(len(power) // _WINDOW, 1))
        centres = np.cumsum([0, *(len(block) for block in blocks[:-1])]) + _WINDOW / 2
        medians = [float(np.median(block)) / float(chdtri(2 * len(parts), 0.5)) for block in blocks]
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
        best = [*peaks[np.argsort(-power[peaks])][:1], *peaks[np.argsort(-ratio[peaks])][:WIDTH]]
        return grid[list(dict.fromkeys(best))].tolist()

    def is_significant(self, number: float, reduction: float, rest: Floats, grid: Floats) -> bool:
        """Whether a wave reduces the sum of squares more than chance, measured by what it leaves around it.

        reduction: of the sum of squares of the training rows; rest: (n,) what is left.
        """
        from scipy.special import chdtri

        if len(grid) < 2:
            return False
        columns = 2 * len(np.unique(self.part[self.signal.train]))
        noise = np.interp(number, grid, self.power(rest, grid)[1])
        return bool(reduction > noise * chdtri(columns, FALSE_ALARM * OVERSAMPLING / len(grid)))


def remainder(columns: Floats, signal: Floats, rows: Bools | slice = slice(None)) -> Floats:
    """(n,) what `columns` (n, c) leave of a `signal` (n,), by a fit to `rows`."""
    return signal - columns @ least_squares(columns[rows], signal[rows])


def wave(coordinate: Floats, wave_number: float) -> Floats:
    """(n, 2) sine and cosine."""
    phase = wave_number * coordinate
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


def wave_numbers(coordinate: Floats, highest: float, lowest: float = 0.0) -> Floats:
    """The grid of a periodogram over a `coordinate` (n,): from one period over all of it, or from `lowest`."""
    cell = 2 * np.pi / max(float(np.ptp(coordinate)), 1e-9)
    return np.arange(max(lowest, cell), highest, cell / OVERSAMPLING)
