"""What an effect looks like: a residual over the quantity on which the effect depends."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.dataset import Dataset
from recordings.recording import Floats

BINS = 40
SAMPLES = 3000
"""Points that are drawn, about."""
_LEAST = 8
"""Samples in a bin; others are left out."""


@dataclass(frozen=True, eq=False)
class BinnedResidual:
    """Samples, thinned out, and the mean in bins of equal width."""

    x: Floats
    """(s,)"""
    y: Floats
    """(s,)"""
    centre: Floats
    """(b,) mean of x in the bin."""
    mean: Floats
    """(b,) mean of y in the bin."""


def axis_values(axis: str, datasets: Sequence[Dataset], computed: Sequence[Floats], joint: int) -> tuple[Floats, str]:
    """The quantity `axis` of a joint in all rows (m,) of all recordings, and its name with its unit."""
    unit = datasets[0].recording.rig.position_units[joint]
    effort = datasets[0].recording.rig.effort_units[joint]
    sources: dict[str, tuple[list[Floats], str]] = {
        "position": ([data.motion.position[:, joint] for data in datasets], f"position [{unit}]"),
        "motor angle": ([data.motion.position[:, joint] for data in datasets], f"position [{unit}]"),
        "velocity": ([data.motion.velocity[:, joint] for data in datasets], f"velocity [{unit}/s]"),
        "acceleration": ([data.motion.acceleration[:, joint] for data in datasets], f"acceleration [{unit}/s²]"),
        "load": ([torque[:, joint] for torque in computed], f"computed load [{effort}]"),
        "time": ([data.time for data in datasets], "time [s]"),
    }
    values, label = sources[axis]
    return np.concatenate(values), label


def bin_means(x: Floats, y: Floats) -> BinnedResidual:
    """`y` (m,) over `x` (m,), without gaps."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    number = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    count = np.bincount(number, minlength=BINS)
    enough = count >= _LEAST
    mean = np.bincount(number, y, BINS)[enough] / count[enough]
    centre = np.bincount(number, x, BINS)[enough] / count[enough]
    thin = slice(None, None, max(1, len(x) // SAMPLES))
    return BinnedResidual(x[thin], y[thin], centre, mean)
