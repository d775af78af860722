"""A residual over the quantity on which an effect depends, and its means in bins."""

from collections.abc import Sequence

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from recordings.recording import Floats

BINS = 40
_MIN_COUNT = 8
"""Bins with fewer samples are left out."""


def axis_values(
    axis: str, recordings: Sequence[PreparedRecording], computed: Sequence[Floats], joint: int
) -> tuple[Floats, str]:
    """Values (m,) of the quantity `axis` of a joint over all rows of all recordings, and its label with the unit."""
    unit = recordings[0].recording.rig.position_units[joint]
    effort = recordings[0].recording.rig.effort_units[joint]
    quantities: dict[str, tuple[list[Floats], str]] = {
        "position": ([data.motion.position[:, joint] for data in recordings], f"position [{unit}]"),
        "motor angle": ([data.motion.position[:, joint] for data in recordings], f"position [{unit}]"),
        "velocity": ([data.motion.velocity[:, joint] for data in recordings], f"velocity [{unit}/s]"),
        "acceleration": ([data.motion.acceleration[:, joint] for data in recordings], f"acceleration [{unit}/s²]"),
        "load": ([torque[:, joint] for torque in computed], f"computed load [{effort}]"),
        "time": ([data.time for data in recordings], "time [s]"),
    }
    values, label = quantities[axis]
    return np.concatenate(values), label


def bin_means(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the means (b,) of `x` and of `y` (m,) in bins of equal width of `x`; rows with NaN are skipped."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    index = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    count = np.bincount(index, minlength=BINS)
    enough = count >= _MIN_COUNT
    centre, mean = (np.bincount(index, values, BINS)[enough] / count[enough] for values in (x, y))
    return centre, mean
