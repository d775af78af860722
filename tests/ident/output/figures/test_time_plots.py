"""Time plots: what is drawn of a long recording."""

import numpy as np

from ident.output.figures.time_plots import visible_points

HOUR = 1_800_000


def test_an_hour_is_decimated_without_losing_peaks() -> None:
    time, y = np.arange(HOUR) / 500, np.zeros(HOUR, np.float32)
    y[1_234_567], y[777_777] = 5.0, np.nan
    xs, ys = visible_points(time, y, (0.0, 3600.0))
    assert len(xs) < 4000
    assert np.nanmax(ys) == 5.0
    assert np.isnan(ys).any(), "gaps are kept"
    xs, ys = visible_points(time, y, (2469.0, 2469.2))
    assert len(xs) >= 100
    assert np.nanmax(ys) == 5.0
    assert xs[0] < 2469.0 < 2469.2 < xs[-1], "the line continues to both edges"
