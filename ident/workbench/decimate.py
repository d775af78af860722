"""Few points that look like many: the least and the greatest of each pixel column."""

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Floats

PIXELS = 900
"""Columns of a plot as wide as the page."""


def decimate(
    time: NDArray[np.floating], y: NDArray[np.floating], start: float, end: float, pixels: int = PIXELS
) -> tuple[Floats, Floats]:
    """The points of `y` (n,) over `time` (n,) between `start` and `end` that matter, at most two a pixel.

    NaN is a gap and stays one: a line must not bridge it.
    """
    first, last = np.searchsorted(time, [start, end])
    first, last = max(int(first) - 1, 0), min(int(last) + 1, len(time))  # one beyond each edge, for the line to it
    time, y = time[first:last], y[first:last]
    if len(y) <= 2 * pixels:
        return time.astype(float), y.astype(float)
    size = -(-len(y) // pixels)
    edges = np.arange(0, len(y), size)
    chosen = [_extremes(y[edge : edge + size]) + edge for edge in edges]
    which = np.unique(np.concatenate(chosen))
    return time[which].astype(float), y[which].astype(float)


def _extremes(y: NDArray[np.floating]) -> NDArray[np.intp]:
    gap = np.isnan(y)
    if gap.all():
        return np.array([0])
    found = [int(np.nanargmin(y)), int(np.nanargmax(y))]
    return np.array([*found, int(gap.argmax())] if gap.any() else found)
