"""One wave over the angle, and what held-out samples say of it in the band in which it stands."""

from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import TINY
from ident.data import cycle_statistics
from ident.diagnosis.judge.improvement import Improvement, block_means, improvement_of_blocks, in_turn
from ident.diagnosis.ripple.waves import JointSignal
from recordings.recording import Bools, Floats

BAND_MARGIN = 1.2
"""Ratio of the ends of a band, or of a spectrum, to the frequencies, or the orders, of the waves in it."""
BLOCK_PERIODS = 3.0
"""Length of a block that counts as independent, in periods of the lowest frequency in it."""
_BAND_SHARE = 0.9
"""Share of the samples whose frequencies make a band: the fastest and the slowest would widen it by noise alone."""


@dataclass(frozen=True)
class BandEvidence:
    """Held-out error with one wave and without it, in the band of the wave."""

    band: tuple[float, float]
    """Its ends [Hz]."""
    before: float
    """RMS error without the wave [N m]."""
    after: float
    """With it."""
    improvement: Improvement

    @classmethod
    def of(
        cls, signal: JointSignal, order: float, held_out: tuple[Floats, Floats], other_way: tuple[Floats, Floats]
    ) -> "BandEvidence":
        """That of a wave of this `order` in the `signal`.

        held_out: residual (n,) without the wave and with it, by a fit to the training rows; other_way: by a fit to
        the test rows. Where the test rows are too few by themselves, each row is held out in turn.
        """
        low, high = _band(signal, order)
        blocks = signal.blocks(BLOCK_PERIODS, low)
        before, after = (signal.within(rest, low, high) for rest in held_out)
        turned = [signal.within(rest, low, high) for rest in other_way]
        test, train = (rows & np.isfinite(before) & np.isfinite(turned[0]) for rows in (signal.test, signal.train))
        noise = _noise(signal, after, test)
        means = [
            np.stack([block_means(blocks[rows], rest[rows] ** 2) for rest in rests])
            for rests, rows in (((before, after), test), (turned, train))
        ]
        first, second, both = (
            improvement_of_blocks(each[0], each[1], np.full(each.shape[1], noise))
            for each in (*means, np.hstack(means))
        )
        errors = [float(np.sqrt((rest[test] ** 2).sum() / max(test.sum(), 1))) for rest in (before, after)]
        return cls((low, high), errors[0], errors[1], in_turn(first, lambda: (second, both)))

    @property
    def pays(self) -> bool:
        """Whether the test rows confirm the wave, and it takes the minimum size of what its band holds."""
        return self.improvement.is_supported and not self.improvement.is_small


@dataclass(frozen=True)
class RippleLine:
    """One wave over the angle of one joint."""

    joint: int
    """From 0."""
    order: float
    """Periods per turn (per 2 pi m of a prismatic joint)."""
    sine: float
    """[N m], the mean of all directions and speeds."""
    cosine: float
    half_width: tuple[float, float, float]
    """Half the 95 % intervals of sine, cosine and order."""
    evidence: BandEvidence
    """Beside all other lines, in the band in which it stands."""
    same_frequency: float | None
    """Frequency of a vibration that explains as much [Hz]; None if none does."""

    @property
    def amplitude(self) -> float:
        """[N m]."""
        return float((self.sine**2 + self.cosine**2) ** 0.5)


def _band(signal: JointSignal, order: float) -> tuple[float, float]:
    """Ends [Hz] of the band above the low-pass in which a wave of this `order` stands at the speeds of `signal`."""
    hertz = np.abs(order * signal.velocity[signal.train]) / (2 * np.pi)
    hertz = hertz[(hertz > signal.low) & (hertz < signal.highest_frequency)]
    if not len(hertz):
        return signal.low, signal.highest_frequency
    slow, fast = np.quantile(hertz, [(1 - _BAND_SHARE) / 2, (1 + _BAND_SHARE) / 2])
    return max(float(slow) / BAND_MARGIN, signal.low), min(float(fast) * BAND_MARGIN, signal.highest_frequency)


def _noise(signal: JointSignal, rest: Floats, rows: Bools) -> float:
    """Variance of the noise in the `rest` (n,) on `rows` (n,): what differs between repetitions; TINY without any."""
    statistics = cycle_statistics.of_residuals(
        [band.prepared.samples for band in signal.bands],
        [part[:, None] for part in signal.parts(rest)],
        [part[:, None] for part in signal.parts(rows)],
    )
    return max(statistics[0].noise, TINY) if statistics else TINY
