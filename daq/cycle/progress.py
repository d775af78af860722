"""Progress of a run, shared by the cycle with the displays."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivers.protocol import Sample

_RECENT = 2000
"""Largest number of cycles that are kept for a display."""


@dataclass
class CycleProgress:
    """Progress figures of a run, written by the cycle and read by the display."""

    phase: str = "start"
    done: int = 0
    total: int = 1
    cycles: int = 0
    lost: int = 0
    """Number of missing answers."""
    missed: int = 0
    """Number of cycles that the host was too late to begin."""
    following_error: float = 0.0
    """Largest following error so far [rad]."""
    lateness: list[float] = field(default_factory=list)
    """Lateness of each cycle [s]."""
    recent: deque[tuple[int, NDArray[np.float64], Sample]] = field(default_factory=lambda: deque(maxlen=_RECENT))
    """SYNC index, reference [rad] and answers of the last cycles; a display may remove them."""
