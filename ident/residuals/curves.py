"""Residual as a function of possible influences: mean and confidence band in bins."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.basics import statistics
from ident.dynamics.effects.base import SignatureAxis
from ident.identification.prediction import Prediction
from recordings.recording import Floats, Ints
from recordings.rig import Rig

CurveAxis = Literal["velocity", "position", "load", "time", "cycle"]
Axis = CurveAxis | SignatureAxis | Literal["load rate"]
AXES: tuple[CurveAxis, ...] = ("velocity", "position", "load", "time", "cycle")

BINS = 24
MIN_SAMPLES = 10
"""Bins with fewer samples are omitted."""
MAX_VISIT = 0.5
"""A visit of a bin counts as one observation, a longer visit as several of this duration [s]."""
MIN_VISITS = 2
"""Minimum effective number of visits of a bin for a confidence interval."""


@dataclass(frozen=True, eq=False)
class BinnedCurve:
    """Residual of one joint in b bins of one quantity, in ascending order of the quantity."""

    axis: CurveAxis
    unit: str
    centre: Floats
    """(b,) mean of the quantity in the bin."""
    mean: Floats
    """(b,) mean residual [N m or N]."""
    half_width: Floats
    """(b,) half width of the 95 % confidence interval of the mean; NaN if the bin has too few visits."""
    rms: Floats
    """(b,) RMS of the residual [N m or N]."""
    samples: Ints
    """(b,) number of samples."""
    explained: float
    """Share of the mean square explained by the bin means, minus the share expected by chance: 0 to 1."""


def binned_curves(predictions: Sequence[Prediction], joint: int) -> tuple[BinnedCurve, ...]:
    """Curves of one joint (0 to dof - 1) over all available AXES, for all recordings together."""
    return tuple(_curve(axis, predictions, joint) for axis in AXES if axis != "cycle" or _cycles(predictions) > 1)


def _cycles(predictions: Sequence[Prediction]) -> int:
    return sum(int(prediction.prepared.repeat.max()) + 1 for prediction in predictions)


def _curve(axis: CurveAxis, predictions: Sequence[Prediction], joint: int) -> BinnedCurve:
    values = axis_values(axis, predictions, joint)
    residual = np.concatenate([prediction.scored_residual[:, joint] for prediction in predictions])
    centre, mean, error, half_width, rms, samples = binned_means(axis, values, residual, predictions)
    square = float(np.nansum(np.where(np.isfinite(values), residual, 0.0) ** 2))
    explained = float((samples * (mean**2 - np.nan_to_num(error) ** 2)).sum() / square) if square else 0.0
    unit = axis_unit(axis, predictions[0].prepared.recording.rig, joint)
    return BinnedCurve(
        axis, unit, centre, mean, half_width, rms, samples.astype(np.int64), min(max(explained, 0.0), 1.0)
    )


def binned_means(axis: Axis, values: Floats, residual: Floats, predictions: Sequence[Prediction]) -> Floats:
    """Statistics (6, b) of the `residual` (m,) in each bin of `values` (m,); NaN where there is none.

    The rows are: centre, mean, its standard error, half width of its interval, RMS, samples. The m samples are those
    of the `predictions`, one after the other.
    """
    usable = np.isfinite(residual) & np.isfinite(values)
    if not usable.any():
        return np.empty((6, 0))
    bins = np.full(len(values), -1)
    bins[usable] = _bins(values[usable], axis, predictions[0].prepared.recording.run.period)
    visit = _visits(bins, predictions)
    keep = [b for b in range(bins.max() + 1) if (bins == b).sum() >= MIN_SAMPLES]
    rows = [_statistics(values[bins == b], residual[bins == b], visit[bins == b]) for b in keep]
    return np.array(rows).reshape(-1, 6).T


def axis_values(axis: Axis, predictions: Sequence[Prediction], joint: int) -> Floats:
    """Quantity (m,) of a joint over all samples of the `predictions`.

    The load is the computed torque, because the measured torque contains the residual.
    """
    if axis == "load":
        return np.concatenate([prediction.computed[:, joint] for prediction in predictions])
    if axis == "load rate":
        return np.concatenate([np.gradient(each.computed[:, joint], 1 / each.prepared.rate) for each in predictions])
    recordings = [prediction.prepared for prediction in predictions]
    if axis == "time":
        return np.concatenate([prepared.time for prepared in recordings])
    if axis == "cycle":
        cycles = [np.where(prepared.repeat >= 0, prepared.repeat + 1.0, np.nan) for prepared in recordings]
        first = np.cumsum([0.0, *(np.nanmax(numbers, initial=0.0) for numbers in cycles[:-1])])
        return np.concatenate([numbers + before for numbers, before in zip(cycles, first, strict=True)])
    signal = "position" if axis == "motor angle" else axis
    return np.concatenate([getattr(prepared.motion, signal)[:, joint] for prepared in recordings])


def axis_unit(axis: Axis, rig: Rig, joint: int) -> str:
    """Return the unit of a quantity of a joint."""
    angle = rig.position_units[joint]
    units = {"velocity": f"{angle}/s", "acceleration": f"{angle}/s²", "load": rig.effort_units[joint], "time": "s"}
    return units.get(axis, "" if axis == "cycle" else angle)


def _bins(values: Floats, axis: Axis, period: float) -> Ints:
    """(n,) number of the bin of each value. Bins are equal in width, or one for each cycle.

    Bins of time are not shorter than the `period` [s] of the motion; otherwise the motion itself would show.
    """
    if axis == "cycle":
        return values.astype(np.int64)
    low, high = float(values.min()), float(values.max())
    count = BINS if axis != "time" or not period else int(np.clip((high - low) / period + 0.1, 1, BINS))
    scaled = (values - low) / (high - low) * count if high > low else np.zeros_like(values)
    return np.minimum(scaled.astype(np.int64), count - 1)


def _visits(bins: Ints, predictions: Sequence[Prediction]) -> Ints:
    """(n,) number of the uninterrupted visit of one bin that a sample belongs to."""
    begins = np.concatenate([[True], np.diff(bins) != 0])
    first = 0
    for prediction in predictions:
        begins[first] = True
        first += len(prediction.residual)
    starts = np.flatnonzero(begins)
    since = np.arange(len(bins)) - np.repeat(starts, np.diff([*starts, len(bins)]))
    longest = max(1, round(MAX_VISIT * predictions[0].prepared.rate))
    return np.cumsum(begins | (since % longest == 0))


def _statistics(values: Floats, residual: Floats, visit: Ints) -> tuple[float, ...]:
    """Statistics of one bin: centre, mean, standard error and half width of the mean's interval, RMS, samples.

    Samples within one visit are correlated, so visits count as observations. Visits of unequal length count as fewer
    visits of equal length.
    """
    _, number = np.unique(visit, return_inverse=True)
    samples, mean = len(residual), float(residual.mean())
    visits = samples**2 / float((np.bincount(number) ** 2.0).sum())
    deviation = np.bincount(number, residual - mean)
    error = half_width = np.nan
    if visits >= MIN_VISITS:
        error = float(np.sqrt((deviation**2).sum() * visits / (visits - 1)) / samples)
        half_width = float(statistics.half_width(np.array(visits - 1))) * error
    return float(values.mean()), mean, error, half_width, float(np.sqrt(np.mean(residual**2))), samples
