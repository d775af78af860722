"""Single samples far outside of what the others are: a lost bit or frame, not a motion."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from recordings.recording import Bools, Floats, Recording

if TYPE_CHECKING:
    from recordings.blocks import SampleTable

MeasuredT = TypeVar("MeasuredT", Recording, "SampleTable")
SIGNALS = ("position", "voltage", "effort")
"""Signals (n, dof) in which outliers are looked for."""

_ORDINARY = 0.99
"""This share of the samples is as far from its neighbours as noise, steps of a converter and impacts make it."""
_MIN_JUMP = 20.0
"""An outlier is this many times as far from them. In 190 recordings without outliers, 7 was the most among samples
beyond the range of the others."""
_MAX_NEIGHBOUR = 0.2
"""The samples before and after it are nearer to the others than this share of its distance: what moves decays."""
_MIN_IMPACTS = 2.0
"""An outlier is this many times as far as the farthest sample that decays into one neighbour: a machine with such
impacts has others that end within one sample."""
_MIN_EXCESS = 0.5
"""An outlier is beyond the range of the other samples by this share of that range."""
_MIN_SAMPLES = 100
"""Fewer samples do not tell what is ordinary."""


def outlying(measured: "Recording | SampleTable") -> Iterator[tuple[str, Floats, Bools]]:
    """Yield name and values (n, dof) of the signals with outliers, and where they are (n, dof)."""
    for name in SIGNALS:
        values = getattr(measured, name)
        if values is not None:
            marks = np.stack([outliers(column) for column in values.T], axis=1)
            if marks.any():
                yield name, values, marks


def without_outliers(measured: MeasuredT) -> MeasuredT:
    """What was `measured`, with gaps in place of outliers."""
    gaps: dict[str, Any] = {name: np.where(marks, np.nan, values) for name, values, marks in outlying(measured)}
    return replace(measured, **gaps)


def outliers(values: Floats) -> Bools:
    """Mark the outliers among `values` (n,); gaps are none."""
    result = np.zeros(len(values), bool)
    known = np.isfinite(values)
    if known.sum() < _MIN_SAMPLES:
        return result
    present = values[known]
    around = np.lib.stride_tricks.sliding_window_view(np.pad(present, 2, mode="reflect"), 5)
    level = np.median(around[:, [0, 1, 3, 4]], axis=1)
    jump = np.abs(present - level)
    step = jump.min(where=jump > 0, initial=np.inf)  # of a converter: a torque that hardly changes has no other jumps
    far = jump > _MIN_JUMP * max(np.quantile(jump, _ORDINARY, method="lower"), step)
    alone = np.abs(around[:, [1, 3]] - level[:, None]).max(axis=1) < _MAX_NEIGHBOUR * jump
    beside = np.pad(jump, 1)
    in_a_row = _MIN_IMPACTS * np.maximum(beside[:-2], beside[2:]) > jump  # each of two lost samples has company, too
    far &= jump > _MIN_IMPACTS * jump.max(where=far & ~alone & ~in_a_row, initial=0.0)
    low, high = present[~far].min(), present[~far].max()
    beyond = np.maximum(present - high, low - present) > _MIN_EXCESS * (high - low)
    result[known] = far & alone & beyond
    return result
