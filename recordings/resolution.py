"""Resolution of measured values: the step of an encoder or a converter."""

import numpy as np

from recordings.recording import Floats

_MIN_SHARE = 0.98
"""Share of the differences between values that must be multiples of the step."""
_MAX_DEVIATION = 0.05
"""Allowed deviation of a difference from a multiple, in steps."""
_SMALLEST = 1e-9
"""Differences below this share of the range are rounding."""
_MAX_STEPS = 1000
"""Only differences of fewer steps are compared: an error of the step adds up in larger ones."""


def resolution(values: Floats) -> float | None:
    """Step of which all differences of `values` (n,) are multiples; None where they are continuous."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return None
    steps = np.diff(levels)
    steps = steps[steps > _SMALLEST * max(np.ptp(levels), float(np.abs(levels).max()))]
    if len(steps) < 2:
        return None
    step = float(np.median(steps[steps < 1.5 * steps.min()]))
    multiples = steps[steps < _MAX_STEPS * step] / step
    return step if np.mean(np.abs(multiples - np.rint(multiples)) < _MAX_DEVIATION) > _MIN_SHARE else None
