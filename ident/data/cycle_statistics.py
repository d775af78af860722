"""What repeats with the motion and what does not: the noise floor without a model of the noise.

The motion repeats, so what differs between repetitions at the same phase is noise, and what they share is not. To be
used on the *residual*: in the torque itself also the controller's reaction to the noise would differ.

What changes steadily from one repetition to the next (a gripper that picks something up, friction that warms up) also
differs between them, yet is no noise; so such a trend is tested for first, and kept apart where there is one.

What repeats holds missing physics, but also what encoder steps and preprocessing leave behind, which repeat as well.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.dataset import Dataset
from ident.filters import convolve
from recordings.recording import Floats

SIGNIFICANT = 0.001
"""A trend less probable than this by chance is not called noise."""
_REACH = 12
"""Rows to either side from which a value between two rows is interpolated."""
_LEAST_PHASES = 10
"""Phases that all repetitions share, below which no trend is sought."""


@dataclass(frozen=True)
class Trend:
    """How the repetitions of one joint's residual change from first to last, as far as one pattern tells it."""

    pattern: str
    """"linear", or "step after k": one level in the first k repetitions, another one from then on."""
    p_value: float
    """Probability of as much by chance; every pattern that was tried is counted."""
    mean_square: float
    """Share of the residual's mean square, beyond what noise puts into the pattern by chance."""

    @property
    def significant(self) -> bool:
        """Whether this is more than chance."""
        return self.p_value < SIGNIFICANT


@dataclass(frozen=True)
class CycleStatistics:
    """Mean square of one joint's residual = repeating + noise + trend (only a significant one).

    All are unbiased, so one that is near zero may come out slightly negative.
    """

    samples: int
    cycles: int
    total: float
    noise: float
    """What differs between repetitions at the same phase, corrected by C / (C - 1)."""
    repeating: float
    """What they share, less the noise / C that is left in their mean."""
    repeating_p: float
    """Probability of as much in common by chance."""
    trend: Trend | None
    """The most conspicuous one; None with fewer than three repetitions, where noise and trend look alike."""

    @property
    def noise_rms(self) -> float:
        """The noise floor, in the unit of the residual."""
        return float(np.sqrt(max(self.noise, 0.0)))

    @property
    def above_noise(self) -> float:
        """Share of the mean square that is not noise, 0 to 1."""
        return min(max(1 - self.noise / self.total, 0.0), 1.0) if self.total else 0.0


def by_cycle(dataset: Dataset, x: Floats) -> Floats:
    """Rows `x` (m, ...) of `dataset` as (cycles, phases, ...): equal phases side by side, NaN where there is no row.

    Where the rows of a repetition do not fall on the phases of the first one, values between rows are interpolated
    by a windowed sinc; they are unknown where that reaches a gap.
    """
    inside = np.flatnonzero(dataset.repeat >= 0)
    names, cycle = np.unique(dataset.repeat[inside], return_inverse=True)
    if not len(names):
        return np.empty((0, 0, *x.shape[1:]))
    # Rows are counted from the first one of the first repetition, which need not be exactly its beginning.
    place = (dataset.phase[inside] - dataset.phase[inside[0]]) * dataset.rate
    offset = np.round(place - np.floor(place + 1e-4), 4)
    phase = np.rint(place - offset).astype(np.int64)
    table = np.full((len(names), max(int(phase.max()), 0) + 1, *x.shape[1:]), np.nan)
    for shift in np.unique(offset):
        moved = _between_rows(x, shift)[inside]
        chosen = (offset == shift) & (phase >= 0)
        table[cycle[chosen], phase[chosen]] = moved[chosen]
    return table


def of_cycles(residual: Floats) -> tuple[CycleStatistics, ...] | None:
    """What repeats in `residual` (cycles, phases, dof) and what does not, joint by joint.

    None where no joint can be judged: at least two repetitions with samples at the same phase are needed.
    """
    joints = [_split(residual[:, :, joint]) for joint in range(residual.shape[2])]
    judged = tuple(joint for joint in joints if joint is not None)
    return judged if len(judged) == len(joints) else None


def pooled(splits: Sequence[tuple[CycleStatistics, ...]]) -> tuple[CycleStatistics, ...] | None:
    """One split per joint for several recordings, weighted by their samples; the clearest trend is kept."""
    return tuple(_pooled(joint) for joint in zip(*splits, strict=True)) if splits else None


def _pooled(parts: Sequence[CycleStatistics]) -> CycleStatistics:
    samples = [part.samples for part in parts]

    def mean(name: str) -> float:
        return float(np.average([getattr(part, name) for part in parts], weights=samples))

    trends = [part.trend for part in parts if part.trend]
    return CycleStatistics(
        samples=sum(samples),
        cycles=min(part.cycles for part in parts),
        total=mean("total"),
        noise=mean("noise"),
        repeating=mean("repeating"),
        repeating_p=min(1.0, len(parts) * min(part.repeating_p for part in parts)),
        trend=min(trends, key=lambda trend: trend.p_value, default=None),
    )


def of_residuals(datasets: Sequence[Dataset], residuals: Sequence[Floats]) -> tuple[CycleStatistics, ...] | None:
    """The split of `residuals` (m, dof), one array for each of `datasets`; None where nothing repeats."""
    splits = [of_cycles(by_cycle(dataset, residual)) for dataset, residual in zip(datasets, residuals, strict=True)]
    return pooled([part for part in splits if part])


def _between_rows(x: Floats, shift: float) -> Floats:
    """`x` (m, ...), each row taken `shift` rows earlier, 0 <= shift < 1."""
    if shift == 0:
        return x
    distance = np.arange(-_REACH, _REACH + 1) - shift
    window = np.i0(6.0 * np.sqrt(np.maximum(1 - (distance / (_REACH + 1)) ** 2, 0)))
    taps = np.sinc(distance) * window
    return convolve(x, taps / taps.sum())


def _split(x: Floats) -> CycleStatistics | None:
    """`x` (cycles, phases)."""
    from scipy.stats import f

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
    freedom = _freedom(deviation)
    cycles = samples / phases
    ratio = (repeating + noise / cycles) * cycles / noise if noise > 0 else np.inf
    return CycleStatistics(
        samples=samples,
        cycles=len(x),
        total=total,
        noise=noise,
        repeating=repeating,
        repeating_p=float(f.sf(ratio, freedom, freedom * (cycles - 1))),
        trend=trend,
    )


def _trend(x: Floats) -> Trend | None:
    """The most conspicuous pattern across the repetitions of `x` (cycles, phases).

    Noise puts the same energy into every contrast between repetitions. A pattern is one contrast, the same at all
    phases in its course over the repetitions, though not in size; its energy is compared with that of all the others.
    """
    from scipy.stats import f

    x = x[np.isfinite(x).mean(axis=1) > 0.5]  # one that was cut short would leave few phases to compare
    x = x[:, np.isfinite(x).all(axis=0)]
    cycles, phases = x.shape
    if cycles < 3 or phases < _LEAST_PHASES:
        return None
    deviation = x - x.mean(axis=0)
    everything = float((deviation**2).sum() / phases)
    freedom = _freedom(deviation)
    patterns = dict(_patterns(cycles))
    found = []
    for name, contrast in patterns.items():
        energy = float(((contrast @ deviation) ** 2).mean())
        others = (everything - energy) / (cycles - 2)
        ratio = energy / others if others > 0 else np.inf if energy > 0 else 1.0
        chance = float(f.sf(ratio, freedom, freedom * (cycles - 2)))
        found.append(Trend(name, min(1.0, len(patterns) * chance), (energy - others) / cycles))
    return min(found, key=lambda trend: (trend.p_value, -trend.mean_square))


def _patterns(cycles: int) -> Iterator[tuple[str, Floats]]:
    """Contrasts (cycles,) of length one that sum to zero."""
    number = np.arange(cycles)
    courses = {"linear": 1.0 * number, **{f"step after {k}": 1.0 * (number >= k) for k in range(1, cycles)}}
    for name, course in courses.items():
        contrast = course - course.mean()
        yield name, contrast / np.linalg.norm(contrast)


def _freedom(deviation: Floats) -> float:
    """How many independent samples one repetition of the noise is worth, in a sum of squares.

    For Gaussian noise of covariance S along the phase this is (tr S)^2 / tr S^2. S has the local variance, from the
    `deviation` (cycles, phases) of all repetitions, and the autocorrelation, from their products; both are estimates,
    whose own scatter is taken off again.
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
        together = float(variance[lag:] @ variance[: phases - lag])
        sum_of_squares += (1 if lag == 0 else 2) * squared * together
    return max(float(variance.sum()) ** 2 / sum_of_squares, 1.0)
