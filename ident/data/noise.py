"""Noise of the measured torque, and the weights that follow from it.

The measured voltage is noisy. The map torque = gain v |v| amplifies its noise by 2 gain |v|, so the samples differ in
precision. At v = 0 the noise does not vanish, because of the curvature of the map, encoder quantization and noise of
the motion. Hence the model of each joint

    variance of the torque = (volts * sensitivity)^2 + floor^2,

with the sensitivity [N m/V] of each row (`PreparedRecording.volt_sensitivity`); volts and floor are estimated from
the data.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.basics import filters
from ident.data import cycle_statistics
from ident.data.cycle_differences import CycleDifferences, between_cycles, cycle_differences
from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import drive_signal, holds_torque
from recordings.recording import Bools, Floats

_MIN_SHARE = 1e-3
"""Lower limit of a standard deviation relative to the joint's largest, so that no single sample dominates."""
_NO_NOISE = 1e-24
"""Added variance [(N m)^2] that keeps weights finite without any noise."""
MEDIAN_OF_NORMAL = 0.6745
"""Median of the absolute value of a standard normal variable."""
_FILTERED = 0.7
"""Level near half of the rate, relative to that near a quarter of it, below which a signal was filtered: 3 dB."""


@dataclass(frozen=True)
class Noise:
    """Noise of one joint within the bandwidth of the analysis."""

    volts: float
    """Standard deviation of the voltage [V]."""
    floor: float
    """Standard deviation of the torque at zero voltage [N m]."""
    source: Literal["repetition", "band above the signal"]

    def torque_std(self, sensitivity: Floats) -> Floats:
        """Standard deviation [N m] of torque samples with the `sensitivity` [N m/V]."""
        return np.hypot(self.volts * sensitivity, self.floor)


def estimate(recordings: Sequence[PreparedRecording], residuals: Sequence[Floats]) -> tuple[Noise, ...]:
    """Estimate the noise of each joint from the `residuals` (m, dof) [N m] of a fit to `recordings`.

    The estimate uses the differences between cycles, if the motion is repeated. Otherwise it uses the voltage above
    the bandwidth of the analysis, assuming white noise; the floor then covers only the curvature of the map.
    """
    dof = recordings[0].torque.shape[1]
    pairs = [_between_cycles(recording, residual) for recording, residual in zip(recordings, residuals, strict=True)]
    square, sensitivity = (np.concatenate(arrays) for arrays in zip(*pairs, strict=True))
    return tuple(
        _from_cycles(square[:, joint], sensitivity[:, joint]) or _from_band_above(recordings, joint)
        for joint in range(dof)
    )


def residual_std(prepared: PreparedRecording, residual: Floats, noise: Sequence[Noise]) -> Floats:
    """Standard deviation (m, dof) [N m] of the residual at each sample; its inverse is the weight of the sample.

    Model errors do not decrease with the voltage as noise does. So the part of `residual` (m, dof) [N m] that exceeds
    the `noise` is added to all samples. Without it, samples near v = 0 would get weights beyond the precision of the
    model.
    """
    columns = []
    for joint, joint_noise in enumerate(noise):
        variance = joint_noise.torque_std(prepared.volt_sensitivity[:, joint]) ** 2
        usable = np.isfinite(residual[:, joint])
        variance = variance + max(float(np.mean(residual[usable, joint] ** 2 - variance[usable])), 0.0)
        columns.append(np.sqrt(np.maximum(variance, _MIN_SHARE**2 * variance[usable].max() + _NO_NOISE)))
    return np.stack(columns, axis=1)


def _between_cycles(prepared: PreparedRecording, residual: Floats) -> tuple[Floats, Floats]:
    """(p, dof) variance [(N m)^2] of the noise and squared sensitivity at each phase; NaN with a single cycle."""
    x = cycle_statistics.by_cycle(prepared, residual)
    squared = cycle_statistics.by_cycle(prepared, prepared.volt_sensitivity**2)
    variance, sensitivity = np.full((2, *x.shape[1:]), np.nan)
    for joint in range(x.shape[2]):
        differences = cycle_differences(x[:, :, joint])
        if differences is not None:
            variance[:, joint], sensitivity[:, joint] = _by_phase(x[:, :, joint], squared[:, :, joint], differences)
    return variance, sensitivity


def _by_phase(x: Floats, squared: Floats, differences: CycleDifferences) -> tuple[Floats, Floats]:
    """(phases,) variance of `x` (cycles, phases) and mean of `squared` (cycles, phases); NaN at a single occurrence.

    If an event disturbs any differences between the cycles, the variance is that of the others.
    """
    known = np.isfinite(differences.values)
    repeated = known.any(axis=0)
    variance, sensitivity = np.full((2, x.shape[1]), np.nan)
    if differences.disturbed:
        variance[repeated] = np.nansum(differences.values**2, axis=0)[repeated] / known.sum(axis=0)[repeated] / 2
    else:
        variance[repeated] = between_cycles(x[:, repeated])
    sensitivity[repeated] = np.nanmean(np.where(np.isfinite(x), squared, np.nan)[:, repeated], axis=0)
    return variance, sensitivity


def _from_cycles(variance: Floats, squared: Floats) -> Noise | None:
    """Split the `variance` (p,) at each phase into a part proportional to the `squared` sensitivity and a constant.

    Nonnegative weighted least squares is used, since the scatter of an estimated variance is proportional to it.
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
        coefficients, _ = nnls(columns * weight[:, None], variance * weight)
        expected = columns @ coefficients
    volts, floor = np.sqrt(coefficients)
    return Noise(float(volts), float(floor), "repetition")


def _from_band_above(recordings: Sequence[PreparedRecording], joint: int) -> Noise:
    """Estimate white voltage noise from the band above twice the bandwidth (or above a quarter of the rate).

    The median is robust against voltage steps due to Coulomb friction at reversals. Of several bands the quietest one
    counts, since ripple at high harmonics of the motion is not noise.
    """
    levels = [_quietest_level(drive_signal(prepared.recording)[:, joint], prepared) for prepared in recordings]
    shares = [min(2 * prepared.bandwidth / prepared.recording.run.rate, 1.0) for prepared in recordings]
    volts, share = float(np.mean(levels)), float(np.mean(shares))
    recording = recordings[0].recording
    torque, squared = recording.rig.torque, recording.rig.torque.map == "square" and not holds_torque(recording)
    # At v = 0 the torque of the square map is gain e |e|, of variance 3 gain^2 volts^4.
    curvature = np.sqrt(3 * share) * torque.gain[joint] * volts**2 if squared else 0.0
    return Noise(float(np.sqrt(share)) * volts, float(curvature), "band above the signal")


def _quietest_level(signal: Floats, prepared: PreparedRecording) -> float:
    """Standard deviation of white noise with the level of `signal` (n,) in the quietest band above the bandwidth."""
    rate = prepared.recording.run.rate
    edge, levels = min(2 * prepared.bandwidth, rate / 4), []
    while edge <= rate / 4:
        taps = -filters.low_pass(edge, rate)
        taps[len(taps) // 2] += 1
        levels.append(float(_white_level(signal, taps)))
        edge *= 2
    return min(levels)


def is_filtered(prepared: PreparedRecording) -> Bools:
    """(dof,) whether the noise of the drive's signal falls off towards half of the rate: it is not white.

    Not where the motion reaches the frequencies that are compared.
    """
    signal, rate = drive_signal(prepared.recording), prepared.recording.run.rate
    middle, wide, above = (np.array(filters.low_pass(share * rate, rate)) for share in (0.2, 0.3, 0.4))
    margin = (len(middle) - len(wide)) // 2
    middle -= np.pad(wide, margin)
    above[len(above) // 2] -= 1
    falls: Bools = _white_level(signal, above) < _FILTERED * _white_level(signal, middle)
    return falls & (prepared.bandwidth < 0.2 * rate)


def _white_level(signal: Floats, taps: Floats) -> Floats:
    """(...) standard deviation of white noise of which `taps` leave as much as of `signal` (n, ...)."""
    passed: Floats = np.nanmedian(np.abs(filters.convolve(signal, taps)), axis=0)
    return passed / np.linalg.norm(taps) / MEDIAN_OF_NORMAL
