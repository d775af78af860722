"""The noise of the measured torque, and weights that follow from it.

The noise is in the measured voltage. Through the map torque = gain v |v| it becomes 2 gain |v| times as large in the
torque, so samples are not equally good. At v = 0 something is left all the same: the map's curvature, encoder steps,
noise in the motion. Hence the model of each joint

    variance of the torque = (volts * sensitivity)^2 + floor^2,

with the sensitivity [N m/V] at each sample (`Dataset.volt_sensitivity`), and the two numbers estimated from the data.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident import filters
from ident.data import cycle_statistics
from ident.data.dataset import Dataset
from ident.data.samples import drive_signal
from recordings.recording import Floats

_LEAST_SHARE = 1e-3
"""No standard deviation is taken to be below this share of the joint's largest: no sample may decide alone."""
_TINY = 1e-24
"""[(N m)^2]; makes the inverse finite where there is no noise at all."""
_MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""


@dataclass(frozen=True)
class Noise:
    """Noise of one joint within the analysis bandwidth."""

    volts: float
    """Standard deviation in the voltage [V]."""
    floor: float
    """Standard deviation in the torque where the voltage is zero [N m]."""
    source: Literal["repetition", "band above the signal"]

    def torque_std(self, sensitivity: Floats) -> Floats:
        """Standard deviation [N m] of torque samples with this `sensitivity` [N m/V]."""
        std: Floats = np.hypot(self.volts * sensitivity, self.floor)
        return std


def estimate(datasets: Sequence[Dataset], residuals: Sequence[Floats]) -> tuple[Noise, ...]:
    """The noise of each joint, given the `residuals` (m, dof) [N m] of a fit to `datasets`.

    From what differs between repetitions of the motion, if it is repeated; else from the voltage above the bandwidth
    of the analysis, taken as white, and then without a floor but that of the map's curvature.
    """
    dof = datasets[0].torque.shape[1]
    pairs = [_repeated(dataset, residual) for dataset, residual in zip(datasets, residuals, strict=True)]
    square, sensitivity = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    return tuple(
        _from_repetition(square[:, joint], sensitivity[:, joint]) or _from_band_above(datasets, joint)
        for joint in range(dof)
    )


def residual_std(dataset: Dataset, residual: Floats, noise: Sequence[Noise]) -> Floats:
    """Standard deviation (m, dof) [N m] of what a fit leaves at each sample; its inverse is the sample's weight.

    What a model lacks does not shrink with the voltage as the noise does; so the part of `residual` (m, dof) [N m]
    that is not `noise` is spread over all samples. Without it, samples near v = 0 would be trusted to a precision
    that the model does not have.
    """
    columns = []
    for joint, own in enumerate(noise):
        variance = own.torque_std(dataset.volt_sensitivity[:, joint]) ** 2
        usable = np.isfinite(residual[:, joint])
        variance = variance + max(float(np.mean(residual[usable, joint] ** 2 - variance[usable])), 0.0)
        columns.append(np.sqrt(np.maximum(variance, _LEAST_SHARE**2 * variance[usable].max() + _TINY)))
    return np.stack(columns, axis=1)


def _repeated(dataset: Dataset, residual: Floats) -> tuple[Floats, Floats]:
    """(p, dof) variance [(N m)^2] between repetitions, and squared sensitivity, at each phase; NaN if in one only."""
    x = cycle_statistics.by_cycle(dataset, residual)
    squared = cycle_statistics.by_cycle(dataset, dataset.volt_sensitivity**2)
    count = np.isfinite(x).sum(axis=0)
    known = np.where(count > 1, count, np.nan)
    mean = np.nansum(x, axis=0) / known
    variance: Floats = np.nansum((x - mean) ** 2, axis=0) / (known - 1)
    sensitivity: Floats = np.nansum(np.where(np.isfinite(x), squared, np.nan), axis=0) / known
    return variance, sensitivity


def _from_repetition(variance: Floats, squared: Floats) -> Noise | None:
    """Split the `variance` (p,) at each phase into a part that grows with the `squared` sensitivity and a constant.

    Least squares with weights, since an estimated variance scatters in proportion to itself; neither part negative.
    """
    from scipy.optimize import nnls

    usable = np.isfinite(variance) & np.isfinite(squared)
    variance, squared = variance[usable], squared[usable]
    if len(variance) < 2 or not variance.any():
        return None
    columns = np.stack([squared, np.ones_like(squared)], axis=1)
    expected = np.full_like(variance, variance.mean())
    for _ in range(5):
        weight = 1 / np.maximum(expected, 1e-3 * variance.mean())
        parts, _ = nnls(columns * weight[:, None], variance * weight)
        expected = columns @ parts
    volts, floor = np.sqrt(parts)
    return Noise(float(volts), float(floor), "repetition")


def _from_band_above(datasets: Sequence[Dataset], joint: int) -> Noise:
    """White noise in the voltage, seen above twice the bandwidth (or a quarter of the rate), reckoned into the band.

    From the median of its size: where the joint reverses, Coulomb friction lets the voltage itself reach up there.
    And from where there is least of it: ripple at high harmonics of the motion is no noise.
    """
    levels = [_least_above(drive_signal(data.recording)[:, joint], data) for data in datasets]
    shares = [min(2 * data.bandwidth / data.recording.run.rate, 1.0) for data in datasets]
    volts, share = float(np.mean(levels)), float(np.mean(shares))
    torque = datasets[0].recording.rig.torque
    # At v = 0 the torque of the square map is gain e |e|, of variance 3 gain^2 volts^4.
    curvature = np.sqrt(3 * share) * torque.gain[joint] * volts**2 if torque.map == "square" else 0.0
    return Noise(float(np.sqrt(share)) * volts, float(curvature), "band above the signal")


def _least_above(signal: Floats, dataset: Dataset) -> float:
    """Standard deviation of white noise of which there is as much as of `signal` (n,) in the quietest band above."""
    rate = dataset.recording.run.rate
    edge, found = min(2 * dataset.bandwidth, rate / 4), []
    while edge <= rate / 4:
        taps = -filters.low_pass(edge, rate)
        taps[len(taps) // 2] += 1
        above = np.abs(filters.convolve(signal, taps))
        found.append(float(np.nanmedian(above)) / float(np.linalg.norm(taps)) / _MEDIAN_OF_NORMAL)
        edge *= 2
    return min(found)
