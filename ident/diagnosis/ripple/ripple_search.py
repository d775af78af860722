"""Search one joint's residual above the low-pass for waves over its angle, and for waves over time.

Waves are found one after the other, each as the highest peak of a periodogram above its neighbourhood, and are then
fitted together (orthogonal matching pursuit). A wave over the angle follows the speed; a vibration keeps its
frequency. Both compete for every peak. At one constant speed they are the same.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, islice

import numpy as np

from ident.diagnosis.judge.improvement import Improvement, improvement_of_blocks
from ident.diagnosis.ripple.waves import (
    JointSignal,
    highest_peaks,
    is_significant,
    least_squares,
    slope,
    wave,
    wave_numbers,
)
from ident.dynamics.effects.periodogram import MAX_PHASE
from ident.uncertainty import covariance
from recordings.recording import Bools, Floats, Ints

LOWEST, HIGHEST = 6.0, 3000.0
"""Range of the waves over the angle [1/turn]."""
MAX_WAVES = 16
"""Number of waves per joint."""
MIN_TORQUE_SHARE = 0.002
"""RMS of a relevant wave as a share of the torque's."""
MIN_T = 3.0
"""Student's t of the correlation of a wave with test rows; training rows have ruled out chance before."""
MIN_DIFFERENCE_T = 2.0
"""Student's t from which a wave over the angle differs from one over time."""
SAME_SHARE = 0.7
"""Share of the reduction by a wave over the angle that a vibration must reach to explain as much."""
_SEPARATION = 2.0
"""Least distance of two waves, in resolution cells: closer ones are a single wave of varying amplitude."""
_STEPS = 4
"""Gauss-Newton steps of a wave number."""
MIN_SAMPLES = 64
"""Training samples and test samples below which no wave is searched."""


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves found in the residual of one joint."""

    orders: Floats
    """(k,) periods per turn (per 2 pi m of a prismatic joint) of the waves over the angle, the first found first."""
    amplitudes: Floats
    """(k, 2) of their sine and cosine [N m]."""
    half_widths: Floats
    """(k, 3) half the 95 % intervals of sine, cosine and order."""
    improvements: tuple[Improvement, ...]
    """Of each wave, on the test rows, over the model without it."""
    same_frequency: Floats
    """(k,) frequency of a vibration that explains as much as the wave [Hz]; NaN if the wave is certain."""
    frequencies: Floats
    """(v,) of waves over time [Hz]."""
    vibrations: Floats
    """(v,) their amplitudes [N m]."""


def search(signal: JointSignal, step: float) -> Waves:
    """Find all waves in a `signal` whose encoder has the given `step` [rad or m]."""
    pursuit = _Pursuit(signal, step)
    while len(pursuit.orders) + len(pursuit.frequencies) < MAX_WAVES and pursuit.extend():
        pass
    return pursuit.result()


class _Pursuit:
    """The waves found so far, and what they leave."""

    def __init__(self, signal: JointSignal, step: float) -> None:
        self.signal = signal
        self.orders: list[float] = []
        self.frequencies: list[float] = []
        self._same: list[float] = []
        self._columns = np.empty((len(signal.residual), 0))
        angle = signal.angle[signal.train]
        self._cell = 2 * np.pi / max(float(np.ptp(angle)), 1e-9) if len(angle) else np.inf
        limits = [HIGHEST, MAX_PHASE * self._cell / (2 * np.pi), 1 / step if step else np.inf]
        if signal.speed:
            limits.append(2 * np.pi * signal.highest_frequency / signal.speed)
        self._orders = wave_numbers(angle, min(limits), LOWEST) if len(angle) else angle

    def extend(self) -> bool:
        """Add the highest confirmed peak; False if there is none."""
        signal = self.signal
        if min(signal.train.sum(), signal.test.sum()) < MIN_SAMPLES:
            return False
        rest = self._rest(self._columns)
        vibrations = self._vibrations(rest)
        strongest = list(islice(vibrations, 1))
        hertz, over_time = strongest[0] if strongest else (np.nan, self._columns)
        for peak in highest_peaks(signal.angle[signal.train], rest[signal.train], self._orders):
            order = signal.refined(signal.angle, peak, self._cell, rest, signal.train)
            over_angle = self._with(wave(signal.angle, order))
            if self._is_close(order) or not self._is_wave(
                over_angle, order, signal.angle, self._orders, signal.train
            ):
                continue
            if self._improvement(over_angle, over_time, signal.train).t > MIN_DIFFERENCE_T:
                break  # a vibration explains more: it comes first
            if self._is_confirmed(over_angle):
                certain = self._improvement(over_time, over_angle, signal.train).t > MIN_DIFFERENCE_T
                certain |= self._reduction(over_time) < SAME_SHARE * self._reduction(over_angle)
                self._same.append(np.nan if certain else hertz)
                self.orders.append(order)
                self._columns = over_angle
                return True
        return self._add_vibration(chain(strongest, vibrations))

    def _add_vibration(self, candidates: Iterable[tuple[float, Floats]]) -> bool:
        """Add the first of the `candidates` that is a vibration."""
        for hertz, columns in candidates:
            if self._lasts(columns):
                self.frequencies.append(hertz)
                self._columns = columns
                return True
        return False

    def result(self) -> Waves:
        """The waves with their amplitudes and uncertainty."""
        signal, k = self.signal, len(self.orders)
        orders = self._jointly_refined() if k else np.empty(0)
        over_angle = np.concatenate([wave(signal.angle, order) for order in orders] or [self._columns[:, :0]], axis=1)
        over_time = [self._time_columns(hertz) for hertz in self.frequencies]
        columns = np.concatenate([signal.above(over_angle), *over_time], axis=1)
        amplitudes = self._solve(columns)
        pairs = amplitudes[: 2 * k].reshape(-1, 2)
        improvements = tuple(
            self._improvement(np.delete(columns, [2 * i, 2 * i + 1], axis=1), columns, signal.test) for i in range(k)
        )
        per_recording = amplitudes[2 * k :].reshape(len(self.frequencies), len(self._recordings), 2)
        return Waves(
            orders,
            pairs,
            self._half_widths(orders, pairs, columns),
            improvements,
            np.array(self._same),
            np.array(self.frequencies),
            np.hypot(per_recording[:, :, 0], per_recording[:, :, 1]).max(axis=1, initial=0.0),
        )

    def _vibrations(self, rest: Floats) -> Iterator[tuple[float, Floats]]:
        """Frequencies [Hz] of significant waves over time, each with all columns with it."""
        signal = self.signal
        for recording in self._recordings:
            here = signal.recording == recording
            alone, rows = signal.of_recording(recording), signal.train & here
            time = signal.time[rows]
            cell = 2 * np.pi / max(float(np.ptp(time)), 1e-9)
            grid = wave_numbers(time, 2 * np.pi * signal.highest_frequency, 2 * np.pi * signal.low)
            band = signal.bands[recording]
            harmonics = band.harmonics(grid)  # whatever repeats with the motion has them all
            for peak in highest_peaks(time, rest[rows], grid):
                omega = alone.refined(alone.time, peak, cell, rest[here], rows[here])
                columns = np.concatenate([self._columns, self._time_columns(omega / (2 * np.pi))], axis=1)
                reference = harmonics if band.repeats(omega / (2 * np.pi)) else grid
                if self._is_wave(columns, omega, signal.time, reference, rows):
                    yield omega / (2 * np.pi), columns

    def _is_wave(self, columns: Floats, wave_number: float, coordinate: Floats, grid: Floats, rows: Bools) -> bool:
        """Whether the last wave of `columns` is significant in `rows` and large enough beside the torque."""
        rest = self._rest(columns)[rows]
        reduction = self._error(self._columns, rows) - float(rest @ rest)
        large = reduction > rows.sum() * (MIN_TORQUE_SHARE * self.signal.torque_rms) ** 2
        return large and is_significant(wave_number, reduction, coordinate[rows], rest, grid)

    def _time_columns(self, hertz: float) -> Floats:
        """(n, 2 r) sine and cosine over time, of each recording on its own: their phases are unrelated."""
        signal = self.signal
        pair = signal.above(wave(signal.time, 2 * np.pi * hertz))
        return np.concatenate(
            [np.where((signal.recording == r)[:, None], pair, 0.0) for r in self._recordings], axis=1
        )

    @cached_property
    def _recordings(self) -> Ints:
        """Those with training rows."""
        return np.unique(self.signal.recording[self.signal.train])

    def _with(self, columns: Floats) -> Floats:
        return np.concatenate([self._columns, self.signal.above(columns)], axis=1)

    def _solve(self, columns: Floats) -> Floats:
        """(c,) coefficients of `columns` (n, c), fitted to the training rows."""
        matrix = columns[self.signal.train]
        return least_squares(matrix, self.signal.residual[self.signal.train])

    def _rest(self, columns: Floats) -> Floats:
        """(n,) residual that `columns` leave."""
        rest: Floats = self.signal.residual - columns @ self._solve(columns)
        return rest

    def _jointly_refined(self) -> Floats:
        """(k,) all orders, refined together."""
        orders = np.array(self.orders)
        time = [self._time_columns(hertz) for hertz in self.frequencies]
        for _ in range(_STEPS):
            waves = [wave(self.signal.angle, order) for order in orders]
            columns = np.concatenate([self.signal.above(np.concatenate(waves, axis=1)), *time], axis=1)
            pairs = self._solve(columns)[: 2 * len(orders)].reshape(-1, 2)
            slopes = self.signal.above(self._slopes(orders, pairs))
            step = self._solve(np.concatenate([columns, slopes], axis=1))[-len(orders) :]
            orders = orders + np.clip(step, -self._cell / 10, self._cell / 10)
        return orders

    def _slopes(self, orders: Floats, pairs: Floats) -> Floats:
        """(n, k) derivatives of the waves with respect to their orders."""
        angle = self.signal.angle
        slopes = [slope(angle, wave(angle, order), *pair) for order, pair in zip(orders, pairs, strict=True)]
        return np.stack(slopes, axis=1)

    def _half_widths(self, orders: Floats, pairs: Floats, columns: Floats) -> Floats:
        """(k, 3) half the 95 % intervals of sine, cosine and order of every wave, for autocorrelated residuals."""
        k, signal = len(orders), self.signal
        if not k:
            return np.empty((0, 3))
        regressor = np.concatenate([columns, signal.above(self._slopes(orders, pairs))], axis=1)
        rest = np.where(signal.train, self._rest(columns), np.nan)
        rows = covariance.least_squares(
            regressor[:, None, :], rest[:, None], np.ones((len(rest), 1)), np.full(len(rest), -1)
        )
        widths = covariance.estimate([rows]).half_width()
        return np.stack([widths[: 2 * k : 2], widths[1 : 2 * k : 2], widths[columns.shape[1] :]], axis=1)

    def _reduction(self, columns: Floats) -> float:
        """Of the training rows' sum of squares by the last wave of `columns`."""
        return self._error(self._columns, self.signal.train) - self._error(columns, self.signal.train)

    def _error(self, columns: Floats, rows: Bools) -> float:
        return float(np.sum(self._rest(columns)[rows] ** 2))

    def _improvement(self, before: Floats, after: Floats, rows: Bools) -> Improvement:
        """Improvement from the columns `before` to `after`, both fitted to training rows, on `rows`."""
        blocks = self.signal.blocks[rows]
        count = np.bincount(blocks)

        def means(columns: Floats) -> Floats:
            sums: Floats = np.bincount(blocks, self._rest(columns)[rows] ** 2)[count > 0] / count[count > 0]
            return sums

        return improvement_of_blocks(means(before), means(after))

    def _is_confirmed(self, columns: Floats) -> bool:
        """Whether test rows are correlated with the last wave of `columns`, as it was fitted to training rows."""
        signal, rows = self.signal, self.signal.test
        rest, change = self._rest(self._columns), self._change(columns)
        sums = np.bincount(signal.blocks[rows], (rest * change)[rows])[np.bincount(signal.blocks[rows]) > 0]
        return len(sums) > 2 and sums.mean() > MIN_T * sums.std(ddof=1) / np.sqrt(len(sums))

    def _change(self, columns: Floats) -> Floats:
        """(n,) change of the computed residual by the last wave of `columns`."""
        return self._rest(self._columns) - self._rest(columns)

    def _is_close(self, order: float) -> bool:
        return any(abs(order - other) < _SEPARATION * self._cell for other in self.orders)

    def _lasts(self, columns: Floats) -> bool:
        """Whether the last wave over time reduces the error in both halves of the training rows."""
        order = np.cumsum(self.signal.train)
        first = self.signal.train & (order <= order[-1] / 2)
        return all(
            self._error(columns, half) < self._error(self._columns, half)
            for half in (first, self.signal.train & ~first)
        )
