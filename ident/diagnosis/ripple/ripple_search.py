"""Search one joint's residual above the low-pass for waves over its angle, and for waves over time.

Waves are found one after the other, each as the highest peak of a periodogram above its neighbourhood, and are then
fitted together (orthogonal matching pursuit). A wave over the angle follows the speed; a vibration keeps its
frequency. Both compete for every peak. At one constant speed they are the same.

A drive attenuates and delays a ripple. Its amplitude and phase therefore follow the speed and the direction, which
gives it sidebands. They are fitted and removed with it, and are no waves of their own.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ident.diagnosis.judge.improvement import Improvement, improvement_of_blocks
from ident.diagnosis.ripple.waves import MIN_SAMPLES, Carrier, JointSignal, least_squares, wave, wave_numbers
from ident.dynamics.effects.periodogram import MAX_PHASE
from ident.uncertainty import covariance
from recordings.recording import Bools, Floats

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
SAME_ORDER = 0.02
"""Relative difference of two orders up to which they are one ripple and a sideband of it."""


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves found in the residual of one joint."""

    orders: Floats
    """(k,) periods per turn (per 2 pi m of a prismatic joint) of the waves over the angle, the first found first."""
    amplitudes: Floats
    """(k, 2) of their sine and cosine [N m], the mean of all directions and speeds."""
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
    if min(signal.train.sum(), signal.test.sum()) < MIN_SAMPLES:
        none = np.empty(0)
        return Waves(none, np.empty((0, 2)), np.empty((0, 3)), (), none, none, none)
    pursuit = _Pursuit(signal, step)
    while len(pursuit.orders) + len(pursuit.frequencies) < MAX_WAVES and pursuit.extend():
        pass
    return pursuit.result()


class _Pursuit:
    """The waves found so far, and what they leave."""

    def __init__(self, signal: JointSignal, step: float) -> None:
        self.signal = signal
        self.orders: list[float] = []
        self.same: list[float] = []
        self.frequencies: list[float] = []
        self.vibrations: list[float] = []
        self._starts: list[int] = []
        self.rest = signal.residual
        self._columns = np.empty((len(signal.residual), 0))

        angle = signal.angle[signal.train]
        limits = [HIGHEST, MAX_PHASE / max(float(np.ptp(angle)), 1e-9), 1 / step if step else np.inf]
        if signal.speed:
            limits.append(2 * np.pi * signal.highest_frequency / signal.speed)
        self._orders = wave_numbers(angle, min(limits), LOWEST)
        self._omegas = wave_numbers(
            signal.time[signal.train], 2 * np.pi * signal.highest_frequency, 2 * np.pi * signal.low
        )

    def extend(self) -> bool:
        """Add the highest confirmed peak; False if there is none."""
        hertz, columns, change = self._vibration()
        for order, candidate, ripple in self._candidates(self.signal.over_angle, self._orders):
            if self._is_better(change, ripple):
                break  # a vibration explains more: it comes first
            certain = self._is_better(ripple, change)
            if self._is_confirmed(ripple):
                certain |= self._reduction(change) < SAME_SHARE * self._reduction(ripple)
                self.same.append(np.nan if certain else hertz)
                self.orders.append(order)
                self._starts.append(self._columns.shape[1])
                return self._add(candidate)
            if certain:  # the vibration is a part of a ripple, even if other waves still hide it from the test rows
                hertz, change = np.nan, np.zeros_like(change)
        if np.isnan(hertz):
            return False
        amplitudes = np.hypot(*self.signal.over_time.coefficients(columns, self.rest)[self.signal.train].T)
        self.frequencies.append(hertz)
        self.vibrations.append(float(amplitudes.max()))
        return self._add(columns)

    def _candidates(self, carrier: Carrier, grid: Floats) -> Iterator[tuple[float, Floats, Floats]]:
        """Wave numbers of significant waves, each with its columns (n, c) and what it explains (n,)."""
        signal = self.signal
        over_angle = carrier is signal.over_angle
        for peak in carrier.peaks(self.rest, grid, over_angle & self._is_known(grid)):
            number = carrier.refined(peak, self.rest)
            columns = carrier.columns(number)
            change = carrier.fitted(columns, self.rest)
            repeats = [] if over_angle else [band for band in signal.bands if band.repeats(number / (2 * np.pi))]
            # Whatever repeats with the motion has all of its harmonics.
            reference = repeats[0].harmonics(grid) if repeats else grid
            reduction = self._reduction(change)
            large = reduction > signal.train.sum() * (MIN_TORQUE_SHARE * signal.torque_rms) ** 2
            if large and carrier.is_significant(number, reduction, self.rest - change, reference) and not (over_angle and self._is_known(number)):
                yield number, columns, change

    def _vibration(self) -> tuple[float, Floats, Floats]:
        """Frequency [Hz] of the first wave over time that lasts, its columns (n, c), what it explains (n,)."""
        for omega, columns, change in self._candidates(self.signal.over_time, self._omegas):
            if self._lasts(change):
                return omega / (2 * np.pi), columns, change
        return np.nan, self._columns, np.zeros_like(self.rest)

    def _add(self, columns: Floats) -> bool:
        self._columns = np.concatenate([self._columns, columns], axis=1)
        self.rest = self.signal.residual - self.signal.over_angle.fitted(self._columns, self.signal.residual)
        return True

    def result(self) -> Waves:
        """The waves with their amplitudes and uncertainty."""
        signal, k = self.signal, len(self.orders)
        estimates = [self._order(*pair) for pair in zip(self.orders, self._starts, strict=True)]
        orders = np.array([order for order, _ in estimates])
        columns = np.concatenate(
            [self._columns[:, :0], *(signal.above(wave(np.nan_to_num(signal.angle), order)) for order in orders)], axis=1
        )
        pairs = least_squares(columns[signal.train], signal.residual[signal.train])
        rest = signal.residual - columns @ pairs
        improvements = []
        for i in range(k):
            fewer = np.delete(columns, [2 * i, 2 * i + 1], axis=1)
            before = signal.residual - fewer @ least_squares(fewer[signal.train], signal.residual[signal.train])
            improvements.append(self._improvement(before, rest, signal.test))
        widths = _half_widths(columns, np.where(signal.train, rest, np.nan)).reshape(k, 2) if k else np.empty((0, 2))
        return Waves(
            orders,
            pairs.reshape(k, 2),
            np.concatenate([widths, np.array([width for _, width in estimates]).reshape(k, 1)], axis=1),
            tuple(improvements),
            np.array(self.same),
            np.array(self.frequencies),
            np.array(self.vibrations),
        )

    def _order(self, order: float, index: int) -> tuple[float, float]:
        """The mean order of a wave over recordings and directions, and half its 95 % interval.

        The interval covers what differs between them, such as delays, beside the noise.
        """
        from scipy.special import stdtrit

        signal, carrier = self.signal, self.signal.over_angle
        own = np.sum((self._columns * carrier.coefficients(self._columns, signal.residual))[:, index : index + 2], axis=1)
        target = self.rest + own
        order = carrier.refined(order, target)
        slope, left = carrier.slope(order, target)
        parts = [here for here, _ in carrier.parts if slope[here].any()]
        weights = np.array([slope[here] @ slope[here] for here in parts])
        shifts = np.array([slope[here] @ left[here] for here in parts]) / weights
        freedom = len(parts) - 1
        scatter = np.sqrt(weights @ shifts**2 / weights.sum() / max(freedom, 1))
        between = stdtrit(freedom, 0.975) * scatter if freedom else 0.0
        within = _half_widths(slope[:, None], np.where(signal.train, left, np.nan))[0]
        self.info = [*getattr(self, "info", []), (order, shifts, weights, between, within)]
        return order, float(np.hypot(between, within))

    def _is_known(self, orders: Floats | float) -> Bools:
        """Whether `orders` belong to a wave that was found."""
        known: Bools = np.any([np.abs(orders - other) < SAME_ORDER * other for other in self.orders], axis=0)
        return known

    def _reduction(self, change: Floats) -> float:
        """Of the training rows' sum of squares by what explains `change` (n,)."""
        rows = self.signal.train
        return float(np.sum(self.rest[rows] ** 2) - np.sum((self.rest - change)[rows] ** 2))

    def _is_better(self, first: Floats, second: Floats) -> bool:
        """Whether the change `first` (n,) explains significantly more than the `second` one."""
        return self._improvement(self.rest - second, self.rest - first, self.signal.train).t > MIN_DIFFERENCE_T

    def _improvement(self, before: Floats, after: Floats, rows: Bools) -> Improvement:
        """Improvement between two residuals (n,), on `rows`."""
        means = [self._means(rest**2, rows) for rest in (before, after)]
        return improvement_of_blocks(*means)

    def _means(self, values: Floats, rows: Bools) -> Floats:
        """(b,) means of the `values` (n,) of `rows` in each block."""
        blocks = self.signal.blocks[rows]
        count = np.bincount(blocks)
        means: Floats = np.bincount(blocks, values[rows])[count > 0] / count[count > 0]
        return means

    def _is_confirmed(self, change: Floats) -> bool:
        """Whether test rows are correlated with the `change` (n,) by a wave, as it was fitted to training rows."""
        rows = self.signal.test
        blocks = self.signal.blocks[rows]
        sums = np.bincount(blocks, (self.rest * change)[rows])[np.bincount(blocks) > 0]
        return _student_t(sums) > MIN_T

    def _lasts(self, change: Floats) -> bool:
        """Whether a wave over time is there all the time: no block outweighs others by the logarithm of its error.

        What reversals leave is as periodic as they are, but short.
        """
        rows = self.signal.train
        before, after = (np.log(self._means(rest**2, rows)) for rest in (self.rest, self.rest - change))
        return _student_t(before - after) > MIN_T


def _student_t(values: Floats) -> float:
    """Of the mean of the `values` (b,) of independent blocks."""
    return float(values.mean() / (values.std(ddof=1) / np.sqrt(len(values)))) if len(values) > 2 else 0.0


def _half_widths(regressor: Floats, rest: Floats) -> Floats:
    """(c,) half the 95 % intervals of the coefficients of a `regressor` (n, c), for autocorrelated residuals."""
    count = len(rest)
    rows = covariance.least_squares(regressor[:, None], rest[:, None], np.ones((count, 1)), np.full(count, -1))
    return covariance.estimate([rows]).half_width()
