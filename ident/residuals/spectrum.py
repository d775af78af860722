"""Power spectral density of the residual, the measured torque and the noise."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.filters import contiguous_slices
from ident.data import cycle_statistics, welch
from ident.identification.prediction import Prediction
from recordings.recording import Floats

RESOLUTION = 0.5
"""[Hz]"""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power spectral densities of one joint up to the analysis bandwidth [(N m)^2/Hz or N^2/Hz]."""

    frequency: Floats
    """(f,) [Hz]"""
    residual: Floats
    """(f,)"""
    torque: Floats
    """(f,) of the measured torque."""
    noise: Floats | None
    """(f,) of the part that does not repeat with the motion; None if no motion is repeated."""


def spectrum(predictions: Sequence[Prediction], joint: int) -> Spectrum:
    """Average over all stretches without gaps of all recordings, weighted by their length."""
    prepared = predictions[0].prepared
    torques = [stretch for prediction in predictions for stretch in _stretches(prediction.prepared.torque[:, joint])]
    residuals = [stretch for prediction in predictions for stretch in _stretches(prediction.residual[:, joint])]
    noises = list(_noise(predictions, joint))
    longest = min(max(map(len, signals)) for signals in (torques, residuals, noises) if signals)
    segment = min(round(prepared.rate / RESOLUTION), longest)
    frequency = np.arange(segment // 2 + 1) * prepared.rate / segment
    shown = frequency <= prepared.bandwidth
    residual, torque = (_mean_density(signals, prepared.rate, segment)[shown] for signals in (residuals, torques))
    noise = _mean_density(noises, prepared.rate, segment)[shown] if noises else None
    return Spectrum(frequency[shown], residual, torque, noise)


def _noise(predictions: Sequence[Prediction], joint: int) -> Iterator[Floats]:
    """Yield the differences between repetitions without gaps, scaled to the noise of a single repetition."""
    for prediction in predictions:
        table = cycle_statistics.by_cycle(prediction.prepared, prediction.residual[:, [joint]])[:, :, 0]
        known = np.isfinite(table).sum(axis=0)
        if (known < 2).all():
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.nansum(table, axis=0) / np.where(known > 1, known, np.nan)
            deviation = (table - mean) * np.sqrt(known / (known - 1))
        for cycle in deviation:
            yield from _stretches(cycle)


def _stretches(x: Floats) -> list[Floats]:
    """Stretches of `x` (m,) without gaps."""
    return [x[stretch] for stretch in contiguous_slices(np.isfinite(x))]


def _mean_density(signals: Sequence[Floats], rate: float, segment: int) -> Floats:
    long_enough = [stretch for stretch in signals if len(stretch) >= segment]
    transforms = [welch.transforms(stretch, segment, centred=False) for stretch in long_enough]
    densities = [welch.density(transform, transform, segment, rate) for transform in transforms]
    return np.asarray(
        np.average(densities, axis=0, weights=[len(stretch) for stretch in long_enough]), dtype=np.float64
    )
