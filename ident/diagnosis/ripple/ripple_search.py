"""Search one joint's residual above the low-pass for waves over its angle, and for waves over time.

Waves are found one after the other, each as the highest peak of a periodogram above its neighbourhood, and are then
fitted together (orthogonal matching pursuit). A wave over the angle follows the speed; a vibration keeps its
frequency. Both compete for every peak. At one constant speed they are the same.

A drive attenuates and delays a ripple. Its amplitude and phase therefore follow the speed and the direction, which
gives it sidebands. They are fitted and removed with it, and are no waves of their own.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from ident.basics.statistics import half_width, least_squares
from ident.diagnosis.judge.improvement import MIN_T, block_means, improvement_of_blocks
from ident.diagnosis.ripple.ripple_line import BLOCK_PERIODS, BandEvidence, RippleLine
from ident.diagnosis.ripple.waves import (
    MIN_SAMPLES,
    Carrier,
    JointSignal,
    Vibration,
    remainder,
    wave,
    wave_numbers,
)
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.dynamics.effects.periodogram import MAX_PHASE
from ident.uncertainty import covariance
from recordings.recording import Bools, Floats

LOWEST, HIGHEST = 6.0, 3000.0
"""Range of the waves over the angle [1/turn]."""
MAX_WAVES = 16
"""Number of waves per joint."""
SAME_ORDER = 0.02
"""Relative difference of two orders up to which they are one ripple and a sideband of it."""


def search(signal: JointSignal, step: float) -> tuple[list[RippleLine], list[Vibration]]:
    """Find all waves in a `signal` whose encoder has the given `step` [rad or m]."""
    if min(signal.train.sum(), signal.test.sum()) < MIN_SAMPLES:
        return [], []
    pursuit = _Pursuit(signal, step)
    while len(pursuit.orders) + len(pursuit.vibrations) < MAX_WAVES and pursuit.extend():
        pass
    return pursuit.lines(), pursuit.vibrations


class _Pursuit:
    """The waves found so far, and what they leave."""

    def __init__(self, signal: JointSignal, step: float) -> None:
        self.signal = signal
        self.orders: dict[int, tuple[float, float | None]] = {}
        """By the index of their columns; with the frequency of a vibration that explains as much [Hz]."""
        self.vibrations: list[Vibration] = []
        self.rest = signal.residual
        self._columns = np.empty((len(signal.residual), 0))
        self._min_reduction = signal.train.sum() * (MIN_TORQUE_SHARE * signal.torque_rms) ** 2
        angle = signal.angle[signal.train]
        limits = [
            HIGHEST,
            MAX_PHASE / max(float(np.ptp(angle)), 1e-9),
            1 / step if step else np.inf,
            2 * np.pi * signal.highest_frequency / signal.speed if signal.speed else np.inf,
        ]
        self._blocks = signal.blocks(BLOCK_PERIODS, signal.low)
        self._over_angle, self._over_time = signal.over_angle(), signal.over_time()
        self._grids = {
            self._over_angle: wave_numbers(angle, min(limits), LOWEST),
            self._over_time: wave_numbers(
                signal.time[signal.train], 2 * np.pi * signal.highest_frequency, 2 * np.pi * signal.low
            ),
        }

    def extend(self) -> bool:
        """Add the highest confirmed peak; False if there is none."""
        hertz, vibration = self._vibration()
        for order, ripple in self._candidates(self._over_angle):
            if self._is_better(vibration, ripple):
                break  # a vibration explains more: it comes first
            certain = self._is_better(ripple, vibration)
            self.orders[self._columns.shape[1]] = order, None if certain or np.isnan(hertz) else hertz
            return self._add(self._over_angle.columns(order))
        if np.isnan(hertz):
            return False
        columns = self._over_time.columns(2 * np.pi * hertz)
        pairs = self._over_time.coefficients(columns, self.rest)[self.signal.train]
        self.vibrations.append(Vibration(self.signal.joint, hertz, float(np.hypot(*pairs.T).max())))
        trained = np.isin(self.signal.recording, self.signal.recording[self.signal.train])
        return self._add(columns * trained[:, None])  # in other recordings its phase is unknown

    def _candidates(self, carrier: Carrier) -> Iterator[tuple[float, Floats]]:
        """Wave numbers of significant waves that are large beside the torque, and what each explains (n,)."""
        grid = self._grids[carrier]
        over_angle = carrier is self._over_angle
        for peak in carrier.peaks(self.rest, grid, self._is_known(grid) if over_angle else self._is_heard(grid)):
            if self._reduction(carrier.fitted(carrier.columns(peak), self.rest)) < self._min_reduction:
                continue  # the grid is so fine that a refined wave explains hardly more
            number = carrier.refined(peak, self.rest)
            change = carrier.fitted(carrier.columns(number), self.rest)
            if carrier.is_significant(number, self._reduction(change), self.rest - change, grid):
                yield number, change

    def _reduction(self, change: Floats) -> float:
        """Reduction of the sum of squares of the training rows by a `change` (n,)."""
        return float(np.sum((self.rest**2 - (self.rest - change) ** 2)[self.signal.train]))

    def _vibration(self) -> tuple[float, Floats]:
        """Frequency [Hz] of the first wave over time that lasts, and what it explains (n,); NaN if there is none."""
        for omega, change in self._candidates(self._over_time):
            if self._lasts(change):
                return omega / (2 * np.pi), change
        return np.nan, np.zeros_like(self.rest)

    def _add(self, columns: Floats) -> bool:
        self._columns = np.concatenate([self._columns, columns], axis=1)
        self.rest = self.signal.residual - self._over_angle.fitted(self._columns, self.signal.residual)
        return True

    def lines(self) -> list[RippleLine]:
        """The waves over the angle with their amplitudes and uncertainty, each of which pays beside all others.

        A model has one amplitude and phase for all directions and speeds: with these, the test rows judge once more.
        """
        estimates = {index: self._estimate(index, order) for index, (order, _) in self.orders.items()}
        while estimates:
            lines = self._fitted(estimates)
            idle = [index for index, line in lines.items() if not line.evidence.pays]
            if not idle:
                return list(lines.values())
            weakest = min(idle, key=lambda index: lines[index].evidence.improvement.share)
            del estimates[weakest]
            # The vibration that it may have been is left.
            if (hertz := lines[weakest].same_frequency) and not self._is_heard(2 * np.pi * hertz):
                self.vibrations.append(Vibration(self.signal.joint, hertz, lines[weakest].amplitude))
        return []

    def _fitted(self, estimates: Mapping[int, tuple[float, float]]) -> dict[int, RippleLine]:
        """The waves of the orders `estimates`, with half their intervals, by the same keys, fitted together."""
        signal, k, angle = self.signal, len(estimates), np.nan_to_num(self.signal.angle)
        columns = np.concatenate([signal.above(wave(angle, order)) for order, _ in estimates.values()], axis=1)
        residual, train, test = signal.residual, signal.train, signal.test
        pairs = least_squares(columns[train], residual[train])
        rest, turned = remainder(columns, residual, train), remainder(columns, residual, test)
        widths = _uncertainty(columns, np.where(train, rest, np.nan)).half_width()
        lines = {}
        for i, (index, (order, width)) in enumerate(estimates.items()):
            others = np.delete(columns, [2 * i, 2 * i + 1], axis=1)
            sine, cosine, of_sine, of_cosine = np.concatenate(
                [pairs.reshape(k, 2)[i], widths.reshape(k, 2)[i]]
            ).tolist()
            lines[index] = RippleLine(
                signal.joint,
                order,
                sine,
                cosine,
                half_width=(of_sine, of_cosine, width),
                evidence=BandEvidence.of(
                    signal,
                    order,
                    held_out=(remainder(others, residual, train), rest),
                    other_way=(remainder(others, residual, test), turned),
                ),
                same_frequency=self.orders[index][1],
            )
        return lines

    def _estimate(self, index: int, order: float) -> tuple[float, float]:
        """The mean of an `order`, whose wave has this `index` of its columns, and half its 95 % interval."""
        carrier = self._over_angle
        explained = self._columns * carrier.coefficients(self._columns, self.signal.residual)
        return estimated_order(carrier, order, self.rest + np.sum(explained[:, index : index + 2], axis=1))

    def _is_known(self, orders: Floats | float) -> Bools:
        """Whether `orders` belong to a wave that was found."""
        return np.any([np.abs(orders - other) < SAME_ORDER * other for other, _ in self.orders.values()], axis=0)

    def _is_heard(self, omegas: Floats | float) -> Bools:
        """Whether angular frequencies [rad/s] belong to a vibration that was found."""
        return np.any(
            [np.abs(omegas - 2 * np.pi * each.frequency) < self._over_time.cell for each in self.vibrations], axis=0
        )

    def _is_better(self, first: Floats, second: Floats) -> bool:
        """Whether the change `first` (n,) explains significantly more than the `second` one."""
        before, after = self._means(self.rest - second, self.rest - first)
        return improvement_of_blocks(before, after).is_supported

    def _means(self, *rests: Floats) -> list[Floats]:
        """Mean squares of each of the `rests` (n,) over the blocks of training rows."""
        rows = self.signal.train
        return [block_means(self._blocks[rows], rest[rows] ** 2) for rest in rests]

    def _lasts(self, change: Floats) -> bool:
        """Whether a wave over time is there all the time: no block outweighs others by the logarithm of its error.

        What reversals leave is as periodic as they are, but short.
        """
        before, after = self._means(self.rest, self.rest - change)
        gains = np.log(before) - np.log(after)
        # Student's t: one stroke has too few blocks for a standard score.
        return len(gains) > 2 and bool(gains.mean() > MIN_T * gains.std(ddof=1) / np.sqrt(len(gains)))


def estimated_order(carrier: Carrier, order: float, target: Floats) -> tuple[float, float]:
    """The mean over recordings and directions of an `order` in the `target` (n,), and half its 95 % interval.

    The interval covers what differs between them, such as delays, beside the noise.
    """
    order = carrier.refined(order, target)
    slope, left = carrier.slope(order, target)
    parts = [here for here, _ in carrier.parts if slope[here].any()]
    weights = np.array([slope[here] @ slope[here] for here in parts])
    shifts = np.array([slope[here] @ left[here] for here in parts]) / weights
    within = _uncertainty(slope[:, None], np.where(carrier.signal.train, left, np.nan)).covariance[0, 0]
    scatter = weights @ shifts**2 / weights.sum() / max(len(parts) - 1, 1)
    # Welch and Satterthwaite: the variance between parts is uncertain, as they are few.
    freedom = (len(parts) - 1) * ((within + scatter) / scatter) ** 2 if len(parts) > 1 else np.inf
    return order, float(half_width(np.asarray(freedom)) * np.sqrt(within + scatter))


def _uncertainty(regressor: Floats, rest: Floats) -> covariance.Uncertainty:
    """Of the coefficients of a `regressor` (n, c) that leaves the `rest` (n,), for autocorrelated residuals."""
    count = len(rest)
    rows = covariance.least_squares(regressor[:, None], rest[:, None], np.ones((count, 1)), np.full(count, -1))
    return covariance.estimate([rows])
