"""The noise floor: the error that a correct model reaches.

It consists of noise and of encoder quantization errors. Noise is what differs between repetitions of the motion.
Quantization errors may repeat with the motion and then look like a missing effect, so their size is estimated: a
uniform error of at most half an encoder step is added to the measured motion and propagated to the torque, both
directly and through the attenuation bias of the fitted parameters. The repeating share is estimated from the finest
part of the measured motion, which hardly contains anything but quantization errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident import filters
from ident.data import cycle_statistics, noise
from ident.data.cycle_statistics import Trend
from ident.data.cycles import instants_by_cycle
from ident.data.spectral_lines import SpectralLine, strongest_lines
from ident.diagnosis.split_data import SplitData, rms
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
_TINY = 1e-24


@dataclass(frozen=True, eq=False)
class NoiseFloor:
    """The noise floor of each joint within the bandwidth of the analysis."""

    noise: Floats
    """(dof,) RMS of the part that differs between repetitions, without a trend [N m]."""
    encoder: Floats
    """(dof,) RMS of the repeating part due to encoder quantization [N m]."""
    lines: tuple[SpectralLine | None, ...]
    """Vibration of each joint; it is not part of the noise."""
    trends: tuple[Trend | None, ...]
    """Significant steady change from one repetition to the next, per joint."""

    @property
    def rms(self) -> Floats:
        """(dof,) RMS of both parts together [N m]."""
        together: Floats = np.hypot(self.noise, self.encoder)
        return together


def estimate_noise_floor(material: SplitData, solution: Solution, residuals: Sequence[Floats]) -> NoiseFloor:
    """The noise floor under the `residuals` (m, dof) of a `solution`."""
    splits = cycle_statistics.of_residuals(material.datasets, residuals)
    if splits:
        level = np.array([one.noise_rms for one in splits])
        found = strongest_lines(material.datasets, residuals)
        vibration = np.array([line.mean_square if line else 0.0 for line in found])
        level = np.sqrt(np.maximum(level**2 - vibration, (_MIN_NOISE_SHARE * level) ** 2))
        trends = tuple(one.trend if one.trend and one.trend.significant else None for one in splits)
    else:
        found, trends = (None,) * residuals[0].shape[1], (None,) * residuals[0].shape[1]
        measured = noise.estimate(material.datasets, residuals)
        std = [
            np.stack([own.torque_std(data.volt_sensitivity[:, j]) for j, own in enumerate(measured)], axis=1)
            for data in material.datasets
        ]
        level = rms(std, [one.prepared.usable for one in material.predictors])
    kept, refitted = _perturbation_torque(material, solution)
    judged = material.scored
    parts = [
        _encoder_mean_square(
            evaluator,
            material.perturbed[i],
            judged[i],
            material.repeating_share[i],
            kept[i],
            refitted[i],
            solution,
        )
        for i, evaluator in enumerate(material.predictors)
    ]
    return NoiseFloor(level, np.sqrt(np.mean(parts, axis=0)), found, trends)


def _perturbation_torque(material: SplitData, solution: Solution) -> tuple[list[Floats], list[Floats]]:
    """(m, dof) torque change by perturbed encoder readings in each recording, for the mechanism alone [N m].

    Returned twice: with the parameters of the `solution`, and with those of a fit to the perturbed readings.
    """
    composition = solution.structure
    always = tuple(term for term in composition.terms if term.effect.always_true)
    own = composition.load(solution.x)
    columns, misled = material.perturbed_regressors(replace(composition, terms=always))
    kept = [(other - one) @ own for one, other in columns]
    return kept, [same + other @ (misled @ own) for same, (_, other) in zip(kept, columns, strict=True)]


def _encoder_mean_square(
    evaluator: TorquePredictor,
    disturbed: TorquePredictor,
    judged: Bools,
    repeating: Floats,
    kept: Floats,
    refitted: Floats,
    solution: Solution,
) -> Floats:
    """(dof,) mean square [(N m)^2] of the repeating torque error due to encoder quantization.

    perturbed: the same recording with perturbed encoder readings. fixed, refitted: (m, dof) torque change for the
    mechanism alone. Some effects amplify it; the ratio is estimated from the `scored` rows (m, dof) with clipped
    values, because an amplifier near its limit amplifies without bound.
    """
    course, composition, x = evaluator.course, solution.composition, solution.x
    difference = disturbed.unfiltered(cpreparedtion, x) - structurenfiltered(composition, x)
    seen, alone = (_clipped_mean_square(np.where(judged, one, np.nan)) for one in (course.condition(difference), kept))
    more = np.maximum(seen / np.maximum(alone, _TINY), 1.0)
    expected: Floats = np.nanmean(np.where(course.usable, refitted, np.nan) ** 2, axis=0) * more
    if len(difference) != len(course.samples.position):  # a mean cycle: nothing tells more
        return expected
    known: Floats = expected * repeating * _loop_amplification(evaluator, solution, difference, repeating)
    return known


def _loop_amplification(evaluator: Evaluator, solution: Solution, expected: Floats, repeating: Floats) -> Floats:
    """(dof,) ratio of the observedTorquePredictorare of quantization errors to that of the `expected` ones (n, dof).

    The position loop reacts to quantization, so the real errors are not uniformly distributed. The ratio is estimated
    in a band above the bandwidth of the analysis, where hardly anything else repeats; medians suppress other peaks.
    """
    course = evaluator.course
    left = course.samplpreparedque - evaluator.unfiltered(solution.composition, solution.x)
    low, high = (min(factor * course.dataset.bandwidth, course.sastructure/ 5) for factor in _QUANTIZATION_BAND)
    if high < 1.2 * low:
        return np.ones(left.shape[1])
    repeated, drawn = (
        by_cycle(
        instants_by_cyclese,
            filters.convolve(x, filters.low_pass(high, course.samples.rate))
            - filters.convolve(x, filters.low_pass(low, course.samples.rate)),
        )
        for x in (left, expected)
    )
    cycles = np.isfinite(repeated).sum(axis=0)
    known = (cycles > 1).all(axis=1)
    if len(repeated) < 2 or not known.any():
        return np.ones(left.shape[1])
    mean = np.nanmean(repeated[:, known], axis=0)
    differing = _robust_mean_square(repeated[:, known] - mean) / (len(repeated) - 1)
    most = (_robust_mean_square(mean) - differing) / np.maximum(_robust_mean_square(drawn) * repeating, _TINY)
    return np.clip(most, 1.0, _MAX_AMPLIFICATION)


def _clipped_mean_square(x: Floats) -> Floats:
    """(dof,) mean square of `x` (m, dof) with values clipped at a multiple of the typical value."""
    most = _CLIPPING * np.sqrt(_robust_mean_square(x))
    square: Floats = np.nanmean(np.minimum(np.abs(x), most) ** 2, axis=0)
    return square


def _robust_mean_square(x: Floats) -> Floats:
    """(dof,) mean square of `x` (..., dof), estimated from the median of its absolute value."""
    return (np.nanmedian(np.abs(x.reshape(-1, x.shape[-1])), axis=0) / 0.6745) ** 2
