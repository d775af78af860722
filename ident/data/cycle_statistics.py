"""Statistics of a repeated motion: a repeating part, a trend and noise, without a model of the noise.

Differences between cycles at the same phase are noise; the mean over the cycles is not. The statistics apply to the
*residual*: the torque itself also contains the controller's reaction to the noise.

A steady change from cycle to cycle (a gripper that picks something up, friction that warms up) is not noise either.
Such a trend is tested for first and, if significant, separated from the noise.

The repeating part contains unmodelled dynamics, and also repeating errors of encoder quantization and preprocessing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import Samples
from ident.filters import convolve
from recordings.recording import Floats

SIGNIFICANT = 0.001
"""Significance level of a trend."""
_HALF_WIDTH = 12
"""Half-width of the interpolation filter in rows."""
_MIN_PHASES = 10
"""Minimum number of phases common to all cycles for a test of trends."""


@dataclass(frozen=True)
class Trend:
    """A pattern in the change of one joint's residual from cycle to cycle."""

    pattern: str
    """"linear", or "step after k": one level in the first k cycles, another level in the following ones."""
    p_value: float
    """Probability of such a change by chance, corrected for the number of patterns tested."""
    mean_square: float
    """Part of the residual's mean square, less the contribution of noise to the pattern."""

    @property
    def significant(self) -> bool:
        """Whether the trend is statistically significant."""
        return self.p_value < SIGNIFICANT


@dataclass(frozen=True)
class CycleStatistics:
    """Decomposition of one joint's mean-square residual: repeating + noise + trend (only if significant).

    All estimates are unbiased, so an estimate near zero may be slightly negative.
    """

    samples: int
    cycles: int
    total: float
    noise: float
    """Variance between cycles at the same phase, corrected by C / (C - 1)."""
    repeating: float
    """Mean square of the mean cycle, less the noise / C that remains in the mean."""
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
        repeating_p=min(1.0, len(recordings) * min(recording.repeating_p for recording in recordings)),
        trend=min(trends, key=lambda trend: trend.p_value, default=None),
    )


def of_residuals(
    recordings: Sequence[PreparedRecording], residuals: Sequence[Floats]
) -> tuple[CycleStatistics, ...] | None:
    """Pooled statistics of `residuals` (m, dof), one array for each of `recordings`; None without repeated cycles."""
    statistics = [
        of_cycles(by_cycle(prepared, residual)) for prepared, residual in zip(recordings, residuals, strict=True)
    ]
    return pooled([recording for recording in statistics if recording])


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
    """Statistics of one joint from `x` (cycles, phases); None if no phase occurs twice."""
    from scipy.special import fdtrc

    count = np.isfinite(x).sum(axis=0)
    x, count = x[:, count > 0], count[count > 0]
    samples, phases = int(count.sum()), len(count)
    if samples == phases:
        return None
    mean = np.nansum(x, axis=0) / count
    deviation = x - mean
    total = float(np.nansum(x**2) / samples)
    differing = float(np.nansum(deviation**2) / (samples - phases))
    trend = _trend(x)
    excess = trend.mean_square if trend and trend.significant else 0.0
    noise = differing - excess * samples / (samples - phases)
    repeating = total - noise - excess
    freedom = _degrees_of_freedom(deviation)
    cycles = samples / phases
    ratio = (repeating + noise / cycles) * cycles / noise if noise > 0 else np.inf
    return CycleStatistics(
        samples=samples,
        cycles=len(x),
        total=total,
        noise=noise,
        repeating=repeating,
        repeating_p=float(fdtrc(freedom, freedom * (cycles - 1), max(ratio, 0.0))),
        trend=trend,
    )


def _trend(x: Floats) -> Trend | None:
    """Find the most significant pattern across the cycles of `x` (cycles, phases).

    Noise has the same expected energy in every contrast between cycles. A pattern is a contrast whose amplitude
    depends on the phase. An F test compares its energy with the mean energy of the other contrasts.
    """
    from scipy.special import fdtrc

    x = x[np.isfinite(x).mean(axis=1) > 0.5]  # an incomplete cycle would leave few common phases
    x = x[:, np.isfinite(x).all(axis=0)]
    cycles, phases = x.shape
    if cycles < 3 or phases < _MIN_PHASES:
        return None
    deviation = x - x.mean(axis=0)
    total_energy = float((deviation**2).sum() / phases)
    freedom = _degrees_of_freedom(deviation)
    patterns = dict(_patterns(cycles))
    trends = []
    for name, contrast in patterns.items():
        energy = float(((contrast @ deviation) ** 2).mean())
        others = (total_energy - energy) / (cycles - 2)
        ratio = energy / others if others > 0 else np.inf if energy > 0 else 1.0
        chance = float(fdtrc(freedom, freedom * (cycles - 2), max(ratio, 0.0)))
        trends.append(Trend(name, min(1.0, len(patterns) * chance), (energy - others) / cycles))
    return min(trends, key=lambda trend: (trend.p_value, -trend.mean_square))


def _patterns(cycles: int) -> Iterator[tuple[str, Floats]]:
    """Contrasts (cycles,) of unit norm and zero sum, with their names."""
    number = np.arange(cycles)
    profiles = {"linear": 1.0 * number, **{f"step after {k}": 1.0 * (number >= k) for k in range(1, cycles)}}
    for name, profile in profiles.items():
        contrast = profile - profile.mean()
        yield name, contrast / np.linalg.norm(contrast)


def _degrees_of_freedom(deviation: Floats) -> float:
    """Effective degrees of freedom of the noise of one cycle, in a sum of squares.

    For Gaussian noise of covariance S along the phase this is (tr S)^2 / tr S^2. The local variance and the
    autocorrelation of S are estimated from the `deviation` (cycles, phases) of all cycles; the variance of these
    estimates is subtracted.
    """
    count = np.maximum(np.isfinite(deviation).sum(axis=0) - 1, 1)
    variance = np.nansum(deviation**2, axis=0) / count
    if not variance.any():
        return 1.0
    phases = len(variance)
    contrasts = float(count.mean())
    unit = np.nan_to_num(deviation / np.sqrt(np.where(variance > 0, variance, np.inf)))
    sum_of_squares = 0.0
    for lag in range(max(phases // 4, 1)):
        products = unit[:, lag:] * unit[:, : phases - lag]
        correlation = 1.0 if lag == 0 else float(products.sum() / (unit**2).sum())
        chance = 0.0 if lag == 0 else 1 / (phases * contrasts)
        squared = max(correlation**2 - chance, 0.0) / (1 + 2 * correlation**2 / contrasts)
        product = float(variance[lag:] @ variance[: phases - lag])
        sum_of_squares += (1 if lag == 0 else 2) * squared * product
    return max(float(variance.sum()) ** 2 / sum_of_squares, 1.0)
