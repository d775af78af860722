"""Single samples far outside of what the others are: a lost bit or frame, not a motion."""

import numpy as np

from recordings.recording import Bools, Floats

_ORDINARY = 0.99
"""This share of the samples is as far from its neighbours as noise, steps of a converter and impacts make it."""
_MIN_JUMP = 20.0
"""An outlier is this many times as far from them. In 190 recordings without outliers, 7 was the most among samples
beyond the range of the others."""
_MAX_NEIGHBOUR = 0.2
"""The samples before and after it are nearer to the others than this share of its distance: what moves decays."""
_MIN_EXCESS = 0.5
"""An outlier is beyond the range of the other samples by this share of that range."""
_MIN_SAMPLES = 100
"""Fewer samples do not tell what is ordinary."""


def without_outliers(values: Floats) -> Floats:
    """The `values` (n, dof), NaN at outliers."""
    return np.where(np.stack([outliers(column) for column in values.T], axis=1), np.nan, values)


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
    low, high = present[~far].min(), present[~far].max()
    beyond = np.maximum(present - high, low - present) > _MIN_EXCESS * (high - low)
    result[known] = far & alone & beyond
    return result
