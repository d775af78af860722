"""What the cycle lets others see of a run that is going on."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivers.protocol import Sample

_RECENT = 2000
"""Cycles that wait for a display at most."""


@dataclass
class CycleProgress:
    """What a person may want to see while the run goes on; read by the display, written by the cycle."""

    phase: str = "start"
    done: int = 0
    total: int = 1
    cycles: int = 0
    lost: int = 0
    """Answers that did not come."""
    missed: int = 0
    """Cycles that the host was too late to begin."""
    following_error: float = 0.0
    """Largest so far [rad]."""
    lateness: list[float] = field(default_factory=list)
    """Per cycle [s]."""
    recent: deque[tuple[int, NDArray[np.float64], Sample]] = field(default_factory=lambda: deque(maxlen=_RECENT))
    """SYNC index, reference [rad] and answers of the last cycles; a display may take them out."""
