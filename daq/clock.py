"""When the cycles begin: absolute deadlines on the host's clock, or simulated time in lockstep."""

import time
from typing import Protocol

_OWN_SHARE = 0.15
"""Of the period, for the host's own work ..."""
_OWN_TIME = 1e-3
"""... but no more than that work takes [s]: at the low rates of serial lines, answers get the rest."""


class Clock(Protocol):
    """The time base of one run."""

    answer_timeout: float
    """How long the answers to a SYNC may take [s]."""

    def wait(self, index: int) -> float:
        """Wait for the cycle of SYNC `index`; returns how late it is [s]. The first call starts the clock."""
        ...

    def overdue(self, index: int) -> float:
        """How long ago the cycle of SYNC `index` should have begun [s]; 0 if it is still to come."""
        ...

    def stamp(self, index: int) -> int:
        """Time of SYNC `index` [ns]: its index times the configured period from the first one."""
        ...

    def now(self) -> int:
        """Present time [ns]."""
        ...


class LockstepClock:
    """Simulated time from zero: never waits, never late."""

    answer_timeout = 2.0

    def __init__(self, rate: float) -> None:
        self._period_ns = 1e9 / rate
        self._index = 0

    def wait(self, index: int) -> float:
        """See `Clock`."""
        self._index = index
        return 0.0

    def overdue(self, index: int) -> float:
        """See `Clock`."""
        return 0.0

    def stamp(self, index: int) -> int:
        """See `Clock`."""
        return round(index * self._period_ns)

    def now(self) -> int:
        """See `Clock`."""
        return self.stamp(self._index)


class HostClock:
    """The host's clock. Deadline k is start + k periods whatever happened before, so that lateness never adds up."""

    def __init__(self, rate: float, lead: float = 0.0) -> None:
        """`lead`: by how much a cycle begins before its SYNC [s]."""
        self._period = 1.0 / rate
        self._lead_ns = round(lead * 1e9)
        self._start: float | None = None
        self._epoch = time.time_ns()
        self.answer_timeout = self._period - min(_OWN_SHARE * self._period, _OWN_TIME)

    def wait(self, index: int) -> float:
        """See `Clock`."""
        if self._start is None:
            self._start = time.perf_counter() - index * self._period
            self._epoch = time.time_ns() - round(index * self._period * 1e9)
        remaining = self._start + index * self._period - time.perf_counter()
        if remaining > 0:
            time.sleep(remaining)
        return self.overdue(index)

    def overdue(self, index: int) -> float:
        """See `Clock`."""
        if self._start is None:
            return 0.0
        return max(0.0, time.perf_counter() - (self._start + index * self._period))

    def stamp(self, index: int) -> int:
        """See `Clock`."""
        return self._epoch + self._lead_ns + round(index * self._period * 1e9)

    def now(self) -> int:
        """See `Clock`."""
        return time.time_ns()
