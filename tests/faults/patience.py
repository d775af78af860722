"""Lockstep on a busy computer: no cycle begins while frames of earlier ones are on their way."""

import time
from collections.abc import Callable

from daq.cycle.clock import LockstepClock
from tests.patience import patient

_PATIENCE = 10.0
"""Longest wait for frames on their way [s]."""


class PatientClock(LockstepClock):
    """Lockstep in which a lost answer takes little time, and a late one shifts no later answer."""

    answer_timeout = 0.05

    def __init__(self, rate: float, settled: Callable[[int], bool]) -> None:
        """`settled`: whether all frames of that number of SYNCs have arrived."""
        super().__init__(rate)
        self._settled = settled
        self._syncs = 0

    def wait(self, index: int) -> float:
        """See `Clock`."""
        deadline = time.monotonic() + patient(_PATIENCE)
        while not self._settled(self._syncs) and time.monotonic() < deadline:
            time.sleep(1e-4)
        self._syncs += 1
        return super().wait(index)
