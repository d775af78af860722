"""Timing of the cycles: absolute deadlines on the host's clock, or simulated time in lockstep."""

import time

from drivers.protocol import LOCKSTEP_TIMEOUT

HOST_SHARE = 0.15
"""Share of the period that is reserved for the host's computations."""
_MAX_HOST_TIME = 1e-3
"""Upper bound of that reserve [s]: at the low rates of serial lines, answers get the rest of the period."""
_LEAST_TIMEOUT = 0.05
"""Time in lockstep within which drives that are there answer while others are lost [s]."""


class LockstepClock:
    """Simulated time that begins at zero; it never waits and is never late."""

    answer_timeout: float = LOCKSTEP_TIMEOUT
    """Longest time that the answers to a SYNC may take [s]."""
    simulated = True
    """Whether time stands still between cycles."""

    def __init__(self, rate: float) -> None:
        self._period_ns = 1e9 / rate
        self._index = 0

    def wait(self, index: int) -> float:
        """Wait for the cycle of SYNC `index` and return its lateness [s]. The first call starts the clock."""
        self._index = index
        return 0.0

    def overdue(self, index: int) -> float:
        """Time since the deadline of the cycle of SYNC `index` [s]; 0 before the deadline."""
        return 0.0

    def note_answers(self, missing: int) -> None:
        """Wait less each time that answers are missing: a lost drive must not hold up every cycle to the end."""
        longest = type(self).answer_timeout
        self.answer_timeout = max(self.answer_timeout / 2, _LEAST_TIMEOUT) if missing else longest

    def stamp(self, index: int) -> int:
        """Time of SYNC `index` [ns]: the time of SYNC 0 plus `index` configured periods."""
        return round(index * self._period_ns)

    def now(self) -> int:
        """Present time [ns]."""
        return self.stamp(self._index)


class HostClock:
    """The host's clock. Deadline k is always start + k periods, so that lateness does not accumulate."""

    simulated = False

    def __init__(self, rate: float, lead: float = 0.0) -> None:
        """`lead`: time from the beginning of a cycle to its SYNC [s]."""
        self._period = 1.0 / rate
        self._lead_ns = round(lead * 1e9)
        self._start: float | None = None
        self._epoch = time.time_ns()
        self.answer_timeout = self._period - min(HOST_SHARE * self._period, _MAX_HOST_TIME)

    def wait(self, index: int) -> float:
        """See `LockstepClock`."""
        if self._start is None:
            self._start = time.perf_counter() - index * self._period
            self._epoch = time.time_ns() - round(index * self._period * 1e9)
        remaining = self._start + index * self._period - time.perf_counter()
        if remaining > 0:
            time.sleep(remaining)
        return self.overdue(index)

    def overdue(self, index: int) -> float:
        """See `LockstepClock`."""
        if self._start is None:
            return 0.0
        return max(0.0, time.perf_counter() - (self._start + index * self._period))

    def note_answers(self, missing: int) -> None:
        """See `LockstepClock`; answers must come within the period anyway."""

    def stamp(self, index: int) -> int:
        """See `LockstepClock`."""
        return self._epoch + self._lead_ns + round(index * self._period * 1e9)

    def now(self) -> int:
        """See `LockstepClock`."""
        return time.time_ns()


Clock = LockstepClock | HostClock
"""The time base of one run."""
