"""The noise floor: the error that a correct model reaches.

It consists of noise and of quantization errors. Noise is what differs between repetitions of the motion; where
nothing repeats, it is what the spectrum above the analysis band shows. Quantization errors may repeat with the motion
and then look like a missing effect, so their size is estimated: a uniform error of at most half an encoder step is
added to the measured motion and propagated to the torque. The repeating share is estimated from the finest part of
the measured motion, which hardly contains anything but quantization errors. The steps of the drives' signal are
simulated in the torque of the model.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from ident.data import cycle_statistics, noise
from ident.data.quantization import drive_errors
from ident.data.spectral_lines import SpectralLine, strongest_lines
from ident.data.trends import Trend
from ident.diagnosis.split.split_data import SplitData, rms
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import TorquePredictor
from ident.threads import in_threads
from recordings.recording import Floats

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
    def limit(self) -> Floats:
        """(dof,) error that a correct model may leave at most [N m]."""
        together: Floats = np.hypot(self.ci95[:, 1], self.least)
        return together

    @property
    def rms(self) -> Floats:
        """(dof,) RMS of both parts together [N m]."""
        together: Floats = np.hypot(self.noise, self.quantization)
        return together


def estimate_noise_floor(split: SplitData, solution: Solution, residuals: Sequence[Floats]) -> NoiseFloor:
    """The noise floor under the `residuals` (m, dof) of a `solution`."""
    statistics = cycle_statistics.of_residuals(split.recordings, residuals)
    vibrations = strongest_lines(split.recordings, residuals)
    least = MIN_TORQUE_SHARE * split.torque_rms
    trends: tuple[Trend | None, ...] = (None,) * len(least)
    if statistics:
        differing = np.array([statistic.noise_rms for statistic in statistics])
        vibration = np.array([line.mean_square if line else 0.0 for line in vibrations])
        level = np.sqrt(np.maximum(differing**2 - vibration, np.minimum(differing, least) ** 2))
        trends = tuple(
            statistic.trend if statistic.trend and statistic.trend.significant else None for statistic in statistics
        )
    else:
        level = _level_above_the_signal(split, residuals)
    mean_squares = in_threads(
        partial(_quantization_mean_square, solution),
        split.predictors,
        split.perturbed,
        split.repeating_share,
    )
    source: NoiseSource = "repetition" if statistics else "spectrum"
    return NoiseFloor(level, np.sqrt(np.mean(mean_squares, axis=0)), source, vibrations, trends, least)


def _level_above_the_signal(split: SplitData, residuals: Sequence[Floats]) -> Floats:
    """(dof,) RMS of the torque noise [N m] if the noise above the bandwidth of the analysis is white."""
    noise_models = noise.estimate(split.recordings, residuals)
    std = [
        np.stack([model.torque_std(data.volt_sensitivity[:, j]) for j, model in enumerate(noise_models)], axis=1)
        for data in split.recordings
    ]
    return rms(std, [data.usable for data in split.recordings])


def _quantization_mean_square(
    solution: Solution, predictor: TorquePredictor, perturbed: TorquePredictor, repeating: Floats
) -> Floats:
    """(dof,) mean square [(N m)^2] of the torque errors due to the steps of the encoders and of the drives' signal.

    repeating: (dof,) share of the encoders' part that is the same in all repetitions.
    """
    prepared, structure, x = predictor.prepared, solution.structure, solution.x
    torque = predictor.unfiltered(structure, x)
    by_encoders = prepared.condition(perturbed.unfiltered(structure, x) - torque)
    squares: Floats = np.nanmean(np.where(prepared.usable, by_encoders, np.nan) ** 2, axis=0) * repeating
    products = [first * second for first, second in drive_errors(prepared, torque)]
    if products:
        squares += np.maximum(np.nanmean(np.where(prepared.usable, products, np.nan), axis=(0, 1)), 0.0)
    return squares
