"""What a model leaves at each place of a motion in healthy recordings: range and scatter of block means."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import TINY
from ident.data.cycle_statistics import by_cycle
from ident.identification.prediction import Prediction
from ident.watch.blocks import BlockMaker, Visit, rows_of
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Recording

MIN_VISITS = 4
"""Visits in healthy recordings from which a place counts: with fewer, their range says little of the next one."""
MIN_BLOCK = 0.1
"""Least duration of a block [s]: what effects do within less, at reversals, is seen in the mean, too."""
_CORRELATION_TIMES = 4.0
"""Duration of a block, in correlation times of the residual: neighbours then hardly tell of each other."""
_SAME_PLACE = 0.02
"""Largest difference of position and velocity from those of the healthy visits, relative to their range."""
_SAME_TEMPERATURE = 1.0
"""Largest distance from the temperatures of healthy recordings [degC]: the resolution of what drives report."""
_NEIGHBOURS = 4
"""Neighbouring blocks whose correlation counts in the long-run variance."""
_CONFIDENCE = 0.05
"""Probability by which the standard deviation of a block may be larger than what is taken for it."""
_SAME_PERIOD = 1e-6


@dataclass(frozen=True, eq=False)
class Baseline:
    """The healthy visits of each place (places, dof)."""

    period: float
    """Of the motion [s]."""
    low: Floats
    """NaN at places and joints with too few visits."""
    high: Floats
    std: Floats
    """Standard deviation of a block's mean."""
    motion: Floats
    """(places, 2 dof) position and velocity."""
    tolerance: Floats
    """(2 dof,) of the motion."""
    temperature: tuple[Floats, Floats]
    """(dof,) lowest and highest; NaN where none was measured."""
    cycles: tuple[Floats, ...]
    """Residual (places, dof) of each healthy cycle, in their order."""

    def counts(self, block: Visit) -> Bools:
        """(dof,) joints of a block that the healthy recordings tell of: same place, temperatures that were seen."""
        low, high = self.temperature
        same_place = bool((np.abs(block.motion - self.motion[block.place]) <= self.tolerance).all())
        new = (block.temperature < low - _SAME_TEMPERATURE) | (block.temperature > high + _SAME_TEMPERATURE)
        return np.isfinite(block.residual) & np.isfinite(self.low[block.place]) & same_place & ~new


def baseline(predictions: Sequence[Prediction], period: float) -> Baseline:
    """Describe what a model leaves in healthy recordings of the motion with this `period` [s].

    Raises:
        BadInput: none of them repeats this motion often enough.
    """
    same = [each for each in predictions if is_same_motion(each.prepared.recording, period)]
    if not same:
        raise BadInput(
            f"healthy recordings of the motion that is watched (period {period:g} s) expected, none found among "
            f"{', '.join(dict.fromkeys(each.prepared.recording.path.name for each in predictions))}; give --healthy"
        )
    length = max(MIN_BLOCK, _CORRELATION_TIMES * correlation_time(same))
    places = max(1, int(period / length))
    recordings = [list(BlockMaker(period, places).blocks(rows_of(each.prepared, each.computed))) for each in same]
    return _described(period, recordings, places)


def is_same_motion(recording: Recording, period: float) -> bool:
    """Whether a `recording` is of a motion with this `period` [s]."""
    return abs(recording.run.period - period) <= _SAME_PERIOD * period


def correlation_time(predictions: Sequence[Prediction]) -> float:
    """Integral of the autocorrelation of what differs from cycle to cycle [s]; the longest of all joints."""
    sums = None
    for each in predictions:
        difference = np.nan_to_num(np.diff(by_cycle(each.prepared, each.residual), axis=0))
        spectrum = np.abs(np.fft.rfft(difference, 2 * difference.shape[1], axis=1)) ** 2
        correlation = np.fft.irfft(spectrum, axis=1)[:, : difference.shape[1]].sum(axis=0)
        sums = correlation if sums is None or len(sums) != len(correlation) else sums + correlation
    assert sums is not None
    until = np.where((sums <= 0).any(axis=0), (sums <= 0).argmax(axis=0), len(sums))
    integrals = [2 * sums[: int(end), joint].sum() / max(sums[0, joint], TINY) - 1 for joint, end in enumerate(until)]
    return max(0.0, *integrals) / predictions[0].prepared.rate


def _by_cycle(blocks: Sequence[Visit], places: int, name: str) -> Floats:
    """(cycles, places, ...) what is called `name` in the `blocks`; NaN where there is none."""
    numbers = {cycle: row for row, cycle in enumerate(dict.fromkeys(block.cycle for block in blocks))}
    table = np.full((len(numbers), places, len(getattr(blocks[0], name))), np.nan)
    for block in blocks:
        table[numbers[block.cycle], block.place] = getattr(block, name)
    return table


def _described(period: float, recordings: Sequence[Sequence[Visit]], places: int) -> Baseline:
    table, motion, temperature = (
        np.concatenate([_by_cycle(blocks, places, name) for blocks in recordings if blocks])
        for name in ("residual", "motion", "temperature")
    )
    known = np.isfinite(table).sum(axis=0) >= MIN_VISITS
    if not known.any():
        raise BadInput(
            f"healthy recordings with at least {MIN_VISITS} whole cycles of the motion expected, {len(table)} found; "
            "record more cycles, or give more recordings by --healthy"
        )
    std = block_std(table)
    lowest, highest = np.fmin.reduce(motion, axis=0), np.fmax.reduce(motion, axis=0)
    return Baseline(
        period=period,
        low=np.where(known, np.fmin.reduce(table, axis=0) - std, np.nan),
        high=np.where(known, np.fmax.reduce(table, axis=0) + std, np.nan),
        std=std,
        motion=(lowest + highest) / 2,
        tolerance=_SAME_PLACE * (np.fmax.reduce(highest, axis=0) - np.fmin.reduce(lowest, axis=0)),
        temperature=(np.fmin.reduce(temperature, axis=(0, 1)), np.fmax.reduce(temperature, axis=(0, 1))),
        cycles=tuple(table),
    )


def block_std(table: Floats) -> Floats:
    """(places, dof) standard deviation of a block, from differences between cycles: `table` (cycles, places, dof).

    It is that of the long run, with the correlation between neighbouring blocks, and not less than that of all places
    of the joint together; upper limits of it, as few cycles tell it badly.
    """
    from scipy.special import chdtri

    difference = np.diff(table, axis=0) / np.sqrt(2)
    flat = np.nan_to_num(difference).reshape(-1, difference.shape[2])
    square = (flat**2).sum(axis=0)
    lags = range(1, min(_NEIGHBOURS, len(flat) - 1) + 1)
    neighbours = np.sum([np.maximum((flat[lag:] * flat[:-lag]).sum(axis=0), 0.0) for lag in lags], axis=0)
    count = np.isfinite(difference).sum(axis=(0, 1))
    # Differences between three cycles share the second one: two thirds of them are independent.
    freedom = np.maximum(2 / 3 * count, 1.0)
    pooled = (square + 2 * neighbours) / np.maximum(count, 1) * freedom / chdtri(freedom, 1 - _CONFIDENCE)
    with np.errstate(invalid="ignore"):
        own = np.nansum(difference**2, axis=0) / np.maximum(np.isfinite(difference).sum(axis=0), 1)
    return np.sqrt(np.maximum(pooled, own))
