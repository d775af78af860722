"""Gaps that a filter reaches: torque and columns are interpolated across them in the same way.

Inside a gap neither is known. The same linear interpolation from the same rows on both sides of the equation biases
no parameter, as the same filter does not; only the position, which is smooth, has to be interpolated well.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from ident.data.preprocessing import Filter, Preprocessed
from ident.data.samples import Samples
from recordings.recording import Bools, Floats


def across_gaps(preprocessed: Preprocessed, samples: Samples, known: Bools) -> Preprocessed:
    """`preprocessed` of `samples` that were interpolated where they are not `known` (n,)."""
    filled = (samples.known & ~known)[preprocessed.instants]
    condition = partial(_conditioned, filled=filled, condition=preprocessed.condition)
    torque = condition(samples.torque[preprocessed.instants])
    return replace(preprocessed, condition=condition, torque=torque, half_width=None)


def _conditioned(x: Floats, *, filled: Bools, condition: Filter) -> Floats:
    """`condition` of `x` (n, ...), whose rows that are `filled` (n,) lie on lines between those that are not."""
    rows, known = np.flatnonzero(filled), np.flatnonzero(~filled)
    after = np.searchsorted(known, rows)
    between = (after > 0) & (after < len(known))  # at the ends there is no line
    rows, after = rows[between], after[between]
    left, right = known[after - 1], known[after]
    weight = ((rows - left) / (right - left)).reshape(-1, *[1] * (x.ndim - 1))
    lines = x.copy()
    lines[rows] = (1 - weight) * x[left] + weight * x[right]
    return condition(lines)
