"""The residual above the low-pass of the analysis, at the full rate of the samples.

The low-pass keeps encoder noise out of the dynamics, but it removes fast ripple as well. What lies above it is
therefore looked at in a band of its own, up to HIGHEST_SHARE of the rate.
"""

from dataclasses import dataclass, replace

import numpy as np

from ident.basics import filters
from ident.basics.threads import in_threads
from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.motion import Motion
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

HIGHEST_SHARE = 0.4
"""Upper end of the band as a share of the sampling rate; higher frequencies are aliases of lower ones."""


@dataclass(frozen=True, eq=False)
class HighBand:
    """One recording above the low-pass: n samples of dof joints."""

    prepared: PreparedRecording
    """With the whole torque, and the motion of the instants."""
    residual: Floats
    """(n, dof) measured minus computed torque above the low-pass [N m]; NaN where unknown."""
    train: Bools
    """(n, dof) samples of training rows."""
    test: Bools
    """(n, dof) samples of test rows."""

    @property
    def motion(self) -> Motion:
        """(n, dof) motion of the samples."""
        return self.prepared.preprocessed.motion

    @property
    def highest(self) -> float:
        """Upper end of the band [Hz]."""
        return HIGHEST_SHARE * self.prepared.samples.rate

    def samples_of(self, rows: Bools) -> Bools:
        """(n, dof) samples of the selected `rows` (m, dof)."""
        return np.repeat(rows, self.prepared.preprocessed.decimation, axis=0)[: len(self.residual)]

    def above(self, x: Floats) -> Floats:
        """The part of `x` (n, ...) above the low-pass."""
        return x - filters.convolve(x, filters.low_pass(self.prepared.bandwidth, self.prepared.samples.rate))

    def within(self, x: Floats, low: float, high: float) -> Floats:
        """The part between the frequencies `low` and `high` [Hz] of `x` (n, ...) above the low-pass."""
        rate = self.prepared.samples.rate
        upper = filters.low_pass(high, rate) if high < self.highest else np.ones(1)
        lower = filters.low_pass(low, rate) if low > self.prepared.bandwidth else np.zeros(1)
        half = max(len(upper), len(lower)) // 2
        wide, narrow = (np.pad(taps, half - len(taps) // 2) for taps in (upper, lower))
        # Of a narrow band, the transitions of both sides meet: its middle is to pass whole.
        gain = np.abs(np.fft.rfft(wide - narrow, 8 * len(wide))).max()
        return filters.convolve(x, (wide - narrow) / gain)


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
    prepared = split.recordings[index]
    samples = prepared.samples
    # What the motion has above the low-pass is encoder noise, or answers to the ripple itself.
    taps = filters.low_pass(prepared.bandwidth, samples.rate)
    slow = TorquePredictor(prepared.with_positions(lambda position: filters.convolve(position, taps)))
    computed = slow.unfiltered(solution.structure, solution.x)
    band = HighBand(prepared, samples.torque, split.train[index], split.test[index])
    band = replace(band, train=band.samples_of(band.train), test=band.samples_of(band.test))
    # Near gaps the slow motion is unknown; above the low-pass it matters only at reversals.
    high = band.above(samples.torque) - np.nan_to_num(band.above(computed))
    known = np.isfinite(band.motion.position) & np.isfinite(band.motion.velocity)
    return replace(band, residual=np.where(known, high, np.nan))
