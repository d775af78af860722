"""The residual above the low-pass of the analysis, at the full rate of the samples.

The low-pass keeps encoder noise out of the dynamics, but it removes fast ripple as well. What lies above it is
therefore looked at in a band of its own, up to HIGHEST_SHARE of the rate.
"""

from dataclasses import dataclass, replace

import numpy as np

from ident.basics import filters
from ident.basics.threads import in_threads
from ident.diagnosis.split.split_data import SplitData
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

HIGHEST_SHARE = 0.4
"""Upper end of the band as a share of the sampling rate; higher frequencies are aliases of lower ones."""
_SAME_PHASE = 0.5
"""Periods by which a wave may shift from the first to the last cycle and still be the same in all of them."""


@dataclass(frozen=True, eq=False)
class HighBand:
    """One recording above the low-pass: n samples of dof joints."""

    time: Floats
    """(n,) [s]"""
    position: Floats
    """(n, dof) [rad or m]"""
    velocity: Floats
    """(n, dof)"""
    torque: Floats
    """(n, dof) measured torque, all frequencies [N m]."""
    residual: Floats
    """(n, dof) measured minus computed torque above the low-pass [N m]; NaN where unknown."""
    train: Bools
    """(n, dof) samples of training rows."""
    test: Bools
    """(n, dof) samples of test rows."""
    rate: float
    """[Hz]"""
    low: float
    """Bandwidth of the low-pass [Hz]."""
    period: float | None
    """Of the repeated motion [s]; None if nothing repeats."""
    decimation: int
    """Samples per row."""

    @property
    def highest(self) -> float:
        """Upper end of the band [Hz]."""
        return HIGHEST_SHARE * self.rate

    def repeats(self, hertz: float) -> bool:
        """Whether a wave over time of this frequency is the same in all cycles, as everything that repeats is."""
        if self.period is None:
            return False
        cycles, periods = (self.time[-1] - self.time[0]) / self.period, hertz * self.period
        return bool(abs(periods - round(periods)) * cycles < _SAME_PHASE)

    def harmonics(self, grid: Floats) -> Floats:
        """Angular frequencies of the repeated motion's harmonics within those of `grid` (f,) [rad/s]."""
        if self.period is None:
            return grid
        base = 2 * np.pi / self.period
        return base * np.arange(np.ceil(grid[0] / base), np.floor(grid[-1] / base) + 1)

    def samples_of(self, rows: Bools) -> Bools:
        """(n, dof) samples of the selected `rows` (m, dof)."""
        return np.repeat(rows, self.decimation, axis=0)[: len(self.time)]

    def above(self, x: Floats) -> Floats:
        """The part of `x` (n, ...) above the low-pass."""
        high: Floats = x - filters.convolve(x, filters.low_pass(self.low, self.rate))
        return high

    def below(self, x: Floats, upper: float) -> Floats:
        """The part of `x` (n, ...) below the frequency `upper` [Hz]."""
        return x if upper >= self.highest else filters.convolve(x, filters.low_pass(upper, self.rate))


def high_bands(split: SplitData, solution: Solution) -> tuple[HighBand, ...]:
    """The residual of `solution` above the low-pass in each recording; empty if a method keeps no samples there.

    It is empty, too, if the method has no low-pass.
    """
    if any(
        len(each.preprocessed.instants) != len(each.samples.position) or not each.cutoff for each in split.recordings
    ):
        return ()
    return tuple(in_threads(lambda index: _high_band(split, index, solution), range(len(split.recordings))))


def _high_band(split: SplitData, index: int, solution: Solution) -> HighBand:
    predictor = split.predictors[index]
    prepared = predictor.prepared
    samples = prepared.samples
    # What the motion has above the low-pass is encoder noise, or answers to the ripple itself.
    taps = filters.low_pass(prepared.bandwidth, samples.rate)
    slow = TorquePredictor(prepared.with_positions(lambda position: filters.convolve(position, taps)))
    computed = slow.unfiltered(solution.structure, solution.x)
    step, motion = prepared.preprocessed.decimation, prepared.preprocessed.motion
    train, test = (np.repeat(rows[index], step, axis=0)[: len(computed)] for rows in (split.train, split.test))
    band = HighBand(
        prepared.instant_time,
        motion.position,
        motion.velocity,
        samples.torque,
        samples.torque,
        train,
        test,
        samples.rate,
        prepared.bandwidth,
        prepared.recording.run.period if (prepared.repeat >= 1).any() else None,
        step,
    )
    # Near gaps the slow motion is unknown; above the low-pass it matters only at reversals.
    high = band.above(samples.torque) - np.nan_to_num(band.above(computed))
    known = np.isfinite(high) & np.isfinite(motion.position) & np.isfinite(motion.velocity)
    return replace(band, residual=np.where(known, high, np.nan))
