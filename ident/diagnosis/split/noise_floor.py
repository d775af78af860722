"""The noise floor: the error that a correct model reaches.

It consists of noise and of quantization errors. Noise is what differs between repetitions of the motion.
Quantization errors may repeat with the motion and then look like a missing effect, so their size is estimated: a
uniform error of at most half an encoder step is added to the measured motion and propagated to the torque, both
directly and through the attenuation bias of the fitted parameters. The repeating share is estimated from the finest
part of the measured motion, which hardly contains anything but quantization errors. The steps of the drives' signal
are simulated in the torque of the model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from ident.basics import filters
from ident.basics.threads import in_threads
from ident.data import cycle_statistics, noise
from ident.data.quantization import drive_errors
from ident.data.spectral_lines import SpectralLine, strongest_lines
from ident.data.trends import Trend
from ident.diagnosis.split.split_data import TINY, SplitData, rms
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Bools, Floats

_MIN_NOISE_SHARE = 0.3
"""At least this share of the noise RMS remains when a vibration is subtracted."""
_QUANTIZATION_BAND = (1.3, 2.2)
"""The frequency band that contains only quantization errors, in multiples of the bandwidth of the analysis."""
_MAX_AMPLIFICATION = 4.0
"""Upper limit of the ratio of observed to expected quantization errors."""
_CLIPPING = 3.0
"""Values are clipped at this multiple of the typical value."""
NoiseSource = Literal["repetition", "spectrum"]
_NOISE_UNCERTAINTY: dict[NoiseSource, float] = {"repetition": 0.03, "spectrum": 0.25}
"""Half the relative 95 % interval of the noise. The spectrum above the analysis band is continued as white: on 33
recordings of the part `chosen` that do not repeat, right models left 0.8 to 1.05 times the floor."""
_QUANTIZATION_UNCERTAINTY = 0.36
"""The same of the mean square of quantization errors."""
MIN_TORQUE_SHARE = 0.0035
"""Residuals below this share of the torque are not called structured: preprocessing may leave as much of a correct
model."""


@dataclass(frozen=True, eq=False)
class NoiseFloor:
    """The noise floor of each joint within the bandwidth of the analysis."""

    noise: Floats
    """(dof,) RMS of the part that differs between repetitions, without a trend [N m]."""
    quantization: Floats
    """(dof,) RMS of the repeating part due to quantization of the encoders and of the drives' signal [N m]."""
    source: NoiseSource
    """From what it is known: from differences between cycles, or, where nothing repeats, from the spectrum."""
    lines: tuple[SpectralLine | None, ...]
    """Vibration of each joint; it is not part of the noise."""
    trends: tuple[Trend | None, ...]
    """Significant steady change from one repetition to the next, per joint."""
    least: Floats
    """(dof,) error below which preprocessing may leave as much of a correct model [N m]."""
    smoothed: Floats
    """(dof,) mean square of the encoders' quantization that is no error of this model, as its effects smooth the
    motion [(N m)^2]; `quantization` does not allow for it."""

    @property
    def ci95(self) -> Floats:
        """(dof, 2) 95 % interval of `rms` [N m]."""
        noise = _NOISE_UNCERTAINTY[self.source]
        return np.stack(
            [
                np.hypot(
                    (1 + side * noise) * self.noise, np.sqrt(1 + side * _QUANTIZATION_UNCERTAINTY) * self.quantization
                )
                for side in (-1, 1)
            ],
            axis=1,
        )

    @property
    def certain(self) -> Floats:
        """(dof,) error above which there may be more than noise [N m]: with the lower end of the noise.

        Quantization counts in full: it repeats, and what smooths, as an elastic joint does, takes some of it.
        """
        return np.hypot((1 - _NOISE_UNCERTAINTY[self.source]) * self.noise, self.quantization)

    @property
    def limit(self) -> Floats:
        """(dof,) error that a correct model may leave at most [N m]."""
        return np.hypot(self.ci95[:, 1], self.least)

    @property
    def rms(self) -> Floats:
        """(dof,) RMS of both parts together [N m]."""
        return np.hypot(self.noise, self.quantization)


def estimate_noise_floor(split: SplitData, solution: Solution, residuals: Sequence[Floats]) -> NoiseFloor:
    """The noise floor under the `residuals` (m, dof) of a `solution`."""
    scored = split.floor_rows
    statistics = cycle_statistics.of_residuals(split.recordings, residuals, scored)
    vibrations = strongest_lines(split.recordings, residuals)
    if statistics:
        level = np.array([statistic.noise_rms for statistic in statistics])
        vibrating = [line.mean_square if line else 0.0 for line in vibrations]
        level = np.sqrt(np.maximum(level**2 - vibrating, (_MIN_NOISE_SHARE * level) ** 2))
    else:
        level = _level_above_the_signal(split, residuals, scored)
    trends = [each.trend if each.trend and each.trend.significant else None for each in statistics or ()]
    fixed, refitted = _perturbation_torque(split, solution)
    mean_squares = in_threads(
        partial(_encoder_mean_square, solution),
        split.predictors,
        split.perturbed,
        scored,
        split.repeating_share,
        fixed,
        refitted,
    )
    encoders, smoothed = np.mean(mean_squares, axis=0)
    drives = in_threads(partial(_drive_mean_square, solution), split.predictors, scored)
    return NoiseFloor(
        level,
        np.sqrt(encoders + np.mean(drives, axis=0)),
        "repetition" if statistics else "spectrum",
        vibrations,
        tuple(trends or [None] * len(level)),
        MIN_TORQUE_SHARE * split.torque_rms,
        smoothed,
    )


def _level_above_the_signal(split: SplitData, residuals: Sequence[Floats], scored: Sequence[Bools]) -> Floats:
    """(dof,) RMS of the torque noise [N m] if the noise above the bandwidth of the analysis is white."""
    noise_models = noise.estimate(split.recordings, residuals)
    std = [
        np.stack(
            [noise_model.torque_std(data.volt_sensitivity[:, j]) for j, noise_model in enumerate(noise_models)],
            axis=1,
        )
        for data in split.recordings
    ]
    return rms(std, scored)


def _perturbation_torque(split: SplitData, solution: Solution) -> tuple[list[Floats], list[Floats]]:
    """(m, dof) torque change by perturbed encoder readings in each recording, for the mechanism alone [N m].

    Returned twice: with the parameters of the `solution`, and with those of a fit to the perturbed readings.
    """
    mandatory = tuple(term for term in solution.structure.terms if term.effect.mandatory)
    parameters = solution.structure.rigid_parameters(solution.x)
    regressors, bias = split.perturbed_regressors(replace(solution.structure, terms=mandatory))
    fixed = [(perturbed - measured) @ parameters for measured, perturbed in regressors]
    return fixed, [
        same + perturbed @ (bias @ parameters) for same, (_, perturbed) in zip(fixed, regressors, strict=True)
    ]


def _encoder_mean_square(
    solution: Solution,
    predictor: TorquePredictor,
    perturbed: TorquePredictor,
    scored: Bools,
    repeating: Floats,
    fixed: Floats,
    refitted: Floats,
) -> Floats:
    """(2, dof) mean square [(N m)^2] of the repeating torque error due to encoder quantization, and what is smoothed.

    Some effects amplify the error of the mechanism alone, and some smooth it. The ratio is estimated from clipped
    values, because an amplifier near its limit amplifies without bound.

    scored: (m, dof) rows that count.

    perturbed: the same recording with perturbed encoder readings.

    fixed, refitted: (m, dof) torque change for the mechanism alone.
    """
    prepared, structure, x = predictor.prepared, solution.structure, solution.x
    difference = perturbed.unfiltered(structure, x) - predictor.unfiltered(structure, x)
    full, mechanism = (
        _clipped_mean_square(np.where(scored, torque, np.nan)) for torque in (prepared.condition(difference), fixed)
    )
    amplification = full / np.maximum(mechanism, TINY**2)
    parts = np.stack([np.maximum(amplification, 1.0), np.maximum(1 - amplification, 0.0)])
    expected: Floats = np.nanmean(np.where(scored, refitted, np.nan) ** 2, axis=0) * parts
    if len(difference) != len(prepared.samples.position):  # a mean cycle: the repeating share is unknown
        return expected
    return expected * repeating * _loop_amplification(predictor, solution, difference, repeating)


def _drive_mean_square(solution: Solution, predictor: TorquePredictor, scored: Bools) -> Floats:
    """(dof,) mean square [(N m)^2] of the repeating torque error in `scored` rows due to the drives' signal."""
    prepared = predictor.prepared
    errors = drive_errors(prepared, predictor.unfiltered(solution.structure, solution.x))
    products = [first * second for first, second in errors]
    if not products:
        return np.zeros(prepared.torque.shape[1])
    together: Floats = np.nanmean(np.where(scored, products, np.nan), axis=(0, 1))
    return np.maximum(together, 0.0)


def _loop_amplification(
    predictor: TorquePredictor, solution: Solution, expected: Floats, repeating: Floats
) -> Floats:
    """(dof,) ratio of the observed mean square of quantization errors to that of the `expected` ones (n, dof).

    The position loop reacts to quantization, so the real errors are not uniformly distributed. The ratio is estimated
    in a band above the bandwidth of the analysis, where hardly anything else repeats; medians suppress other peaks.
    """
    prepared = predictor.prepared
    residual = prepared.samples.torque - predictor.unfiltered(solution.structure, solution.x)
    low, high = (min(factor * prepared.bandwidth, prepared.samples.rate / 5) for factor in _QUANTIZATION_BAND)
    if high < 1.2 * low:
        return np.ones(residual.shape[1])
    measured, simulated = (
        cycle_statistics.by_cycle(
            prepared.samples,
            filters.convolve(x, filters.low_pass(high, prepared.samples.rate))
            - filters.convolve(x, filters.low_pass(low, prepared.samples.rate)),
        )
        for x in (residual, expected)
    )
    complete = (np.isfinite(measured).sum(axis=0) > 1).all(axis=1)
    if len(measured) < 2 or not complete.any():
        return np.ones(residual.shape[1])
    mean = np.nanmean(measured[:, complete], axis=0)
    variance = _robust_mean_square(measured[:, complete] - mean) / (len(measured) - 1)
    ratio = (_robust_mean_square(mean) - variance) / np.maximum(_robust_mean_square(simulated) * repeating, TINY**2)
    return np.clip(ratio, 1.0, _MAX_AMPLIFICATION)


def _clipped_mean_square(x: Floats) -> Floats:
    """(dof,) mean square of `x` (m, dof) with values clipped at a multiple of the typical value."""
    return np.nanmean(np.minimum(np.abs(x), _CLIPPING * np.sqrt(_robust_mean_square(x))) ** 2, axis=0)


def _robust_mean_square(x: Floats) -> Floats:
    """(dof,) mean square of `x` (..., dof), estimated from the median of its absolute value."""
    return (np.nanmedian(np.abs(x.reshape(-1, x.shape[-1])), axis=0) / noise.MEDIAN_OF_NORMAL) ** 2
