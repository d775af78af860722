"""Progress of a run, shared by the cycle with the displays."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from daq.cycle.clock import HOST_SHARE
from drivers.protocol import Sample
from recordings.schemas import Level

_RECENT = 2000
"""Largest number of cycles that are kept for a display."""
_TOLERATED_LOSS = 0.01
"""Share of the answers that may be missing without a word: a bus loses none, and a host with time to spare hardly one
in a thousand."""


def loss_of(lost: int, asked: int, cause: str) -> str | None:
    """What is to be said where `lost` of the answers that were `asked` for are missing; None: few are."""
    if lost <= _TOLERATED_LOSS * asked:
        return None
    return f"{lost} of {asked} answers are missing ({lost / asked:.1%}); {cause}; then record again"


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
    pose: tuple[float, ...] = ()
    """The last complete answer of the drives [rad or m]."""
    following_error: float = 0.0
    """Largest following error so far [rad]."""
    lateness: list[float] = field(default_factory=list)
    """Lateness of each cycle [s]."""
    recent: deque[tuple[int, NDArray[np.float64], Sample]] = field(default_factory=lambda: deque(maxlen=_RECENT))
    """SYNC index, reference [rad] and answers of the last cycles; a display may remove them."""
    reports: deque[tuple[Level, str, str]] = field(default_factory=lambda: deque(maxlen=_RECENT))
    """What was reported (level, source, message); a display may remove it."""

    def loss(self, rate: float, dof: int, *, simulated: bool) -> str | None:
        """What is to be said where many answers of `dof` drives at `rate` [Hz] are missing: how many, the likely
        cause and the next step; None: few are."""
        lost, asked = self.lost + self.missed * dof, (self.cycles + self.missed) * dof
        # A cycle that begins later than by this share takes time from its answers.
        late = sum(lateness > HOST_SHARE / rate for lateness in self.lateness)
        cause = "the cycles were in time: check the cable, and the load of the bus by daq check"
        if simulated:
            cause = "simulated drives need a computer with time to spare: close other programs, use --pace lockstep"
        elif 2 * (late + self.missed) * dof >= lost:
            cause = f"the host was late in {late} cycles, missed {self.missed}: close other programs, lower --rate"
        return loss_of(lost, asked, cause)
