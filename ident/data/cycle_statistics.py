"""Statistics of a repeated motion: a repeating part, a trend and noise, without a model of the noise.

Differences between cycles at the same phase are noise; the mean over the cycles is not. The statistics apply to the
*residual*: the torque itself also contains the controller's reaction to the noise.

A change from cycle to cycle (a gripper that picks something up, friction that warms up) is not noise either. The
noise is estimated from the differences between cycles that no event disturbs, and trends are tested against it.

The repeating part contains unmodelled dynamics, and also repeating errors of encoder quantization and preprocessing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.filters import convolve
from ident.data.cycle_differences import cycle_differences
from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import Samples
from ident.data.trends import Trend, clearest_trend
from recordings.recording import Bools, Floats

_HALF_WIDTH = 12
"""Half-width of the interpolation filter in rows."""
_HALF = 0.5
"""What an interpolated row of ones and zeros exceeds where its nearest row is a one."""


@dataclass(frozen=True)
class CycleStatistics:
    """Decomposition of one joint's mean-square residual: repeating + noise + changing.

    All estimates are unbiased, so an estimate near zero may be slightly negative.
    """

    samples: int
    cycles: int
    total: float
    noise: float
    """Variance of what differs between cycles at random."""
    repeating: float
    """Mean square of the mean cycle, less the part of noise and changes that remains in the mean."""
    changing: float
    """What differs between cycles beyond the noise: a drift, or the difference that an event makes."""
    repeating_p: float
    """Probability of such a repeating part by chance."""
    trend: Trend | None
    """The most significant trend; None with fewer than three cycles, where noise and trend are indistinguishable."""

    @property
    def noise_rms(self) -> float:
        """The noise floor, in the unit of the residual."""
        return float(np.sqrt(max(self.noise, 0.0)))

    @property
    def above_noise(self) -> float:
        """Share of the mean square above the noise, 0 to 1."""
        return min(max(1 - self.noise / self.total, 0.0), 1.0) if self.total else 0.0


def by_cycle(rows: PreparedRecording | Samples, x: Floats) -> Floats:
    """Arrange `x` (m, ...) as (cycles, phases, ...); NaN where there is no row.

    rows: a recording, or for signals at full rate its samples.

    If the rows of a cycle do not fall on the phases of the first one, values are interpolated by a windowed sinc.
    They are NaN where its window reaches a gap.
    """
    inside = np.flatnonzero(rows.repeat >= 0)
    numbers, cycle = np.unique(rows.repeat[inside], return_inverse=True)
    if not len(numbers):
        return np.empty((0, 0, *x.shape[1:]))
    # Phases are counted from the first row of the first cycle, which need not be exactly its beginning.
    place = (rows.phase[inside] - rows.phase[inside[0]]) * rows.rate
    offset = np.round(place - np.floor(place + 1e-4), 4)
    phase = np.rint(place - offset).astype(np.int64)
    table = np.full((len(numbers), max(int(phase.max()), 0) + 1, *x.shape[1:]), np.nan)
    for shift in np.unique(offset):
        shifted = _shift_rows(x, shift)[inside]
        selected = (offset == shift) & (phase >= 0)
        table[cycle[selected], phase[selected]] = shifted[selected]
    return table


def of_cycles(residual: Floats) -> tuple[CycleStatistics, ...] | None:
    """Compute the statistics of `residual` (cycles, phases, dof) for each joint.

    Returns None unless every joint has at least two cycles with samples at the same phase.
    """
    statistics = [_statistics(residual[:, :, joint]) for joint in range(residual.shape[2])]
    known = tuple(joint for joint in statistics if joint is not None)
    return known if len(known) == len(statistics) else None


def pooled(statistics: Sequence[tuple[CycleStatistics, ...]]) -> tuple[CycleStatistics, ...] | None:
    """Pool the statistics of several recordings, weighted by samples; keep the clearest trend of each joint."""
    return tuple(_pooled(joint) for joint in zip(*statistics, strict=True)) if statistics else None


def _pooled(recordings: Sequence[CycleStatistics]) -> CycleStatistics:
    samples = [recording.samples for recording in recordings]

    def mean(name: str) -> float:
        return float(np.average([getattr(recording, name) for recording in recordings], weights=samples))

    trends = [recording.trend for recording in recordings if recording.trend]
    return CycleStatistics(
        samples=sum(samples),
        cycles=min(recording.cycles for recording in recordings),
        total=mean("total"),
        noise=mean("noise"),
        repeating=mean("repeating"),
        changing=mean("changing"),
        repeating_p=min(1.0, len(recordings) * min(recording.repeating_p for recording in recordings)),
        trend=min(trends, key=lambda trend: trend.p_value, default=None),
    )


def of_residuals(
    recordings: Sequence[PreparedRecording | Samples],
    residuals: Sequence[Floats],
    rows: Sequence[Bools] | None = None,
) -> tuple[CycleStatistics, ...] | None:
    """Pooled statistics of `residuals` (m, dof), one array for each of `recordings`; None without repeated cycles.

    recordings: for residuals at full rate, their samples.

    rows: (m, dof) of each recording that count; None: all.
    """
    tables = [by_cycle(prepared, residual) for prepared, residual in zip(recordings, residuals, strict=True)]
    if rows is not None:
        counted = [
            by_cycle(prepared, selected.astype(float)) for prepared, selected in zip(recordings, rows, strict=True)
        ]
        tables = [np.where(share > _HALF, table, np.nan) for table, share in zip(tables, counted, strict=True)]
    return pooled([recording for recording in map(of_cycles, tables) if recording])


def repeating_share(prepared: PreparedRecording) -> Floats:
    """(dof,) repeating share (0 to 1) of the measured position that the low-pass of the motion removes."""
    preprocessed, measured = prepared.preprocessed, prepared.samples.position
    removed = np.full_like(measured, np.nan)
    removed[preprocessed.instants] = measured[preprocessed.instants] - preprocessed.motion.position
    statistics = of_cycles(by_cycle(prepared.samples, removed))
    if statistics is None:
        return np.ones(removed.shape[1])
    return np.array(
        [min(max(joint.repeating / joint.total, 0.0), 1.0) if joint.total else 0.0 for joint in statistics]
    )


def _shift_rows(x: Floats, shift: float) -> Floats:
    """Interpolate `x` (m, ...) at positions `shift` rows earlier, 0 <= shift < 1."""
    if shift == 0:
        return x
    distance = np.arange(-_HALF_WIDTH, _HALF_WIDTH + 1) - shift
    window = np.i0(6.0 * np.sqrt(np.maximum(1 - (distance / (_HALF_WIDTH + 1)) ** 2, 0)))
    taps = np.sinc(distance) * window
    return convolve(x, taps / taps.sum())


def _statistics(x: Floats) -> CycleStatistics | None:
    """Statistics of one joint from `x` (cycles, phases); None if no phase occurs in two consecutive cycles."""
    from scipy.special import fdtrc

    differences = cycle_differences(x)
    if differences is None:
        return None
    count = np.isfinite(x).sum(axis=0)
    x, count = x[:, count > 0], count[count > 0]
    samples, phases = int(count.sum()), len(count)
    deviation = x - np.nansum(x, axis=0) / count
    total = float(np.nansum(x**2) / samples)
    differing = float(np.nansum(deviation**2) / (samples - phases))
    trend, others = clearest_trend(x, differences.noise, differences.freedom) or (None, np.inf)
    # Differences between cycles contain a part of a drift.
    noise = min(differences.noise, others) if trend and trend.significant else differences.noise
    changing = (differing - noise) * (samples - phases) / samples
    repeating = total - noise - changing
    cycles = samples / phases
    ratio = (repeating + noise / cycles) * cycles / noise if noise > 0 else np.inf
    return CycleStatistics(
        samples=samples,
        cycles=len(x),
        total=total,
        noise=noise,
        repeating=repeating,
        changing=changing,
        repeating_p=float(fdtrc(differences.freedom, differences.freedom * (cycles - 1), max(ratio, 0.0))),
        trend=trend,
    )
