"""Time that passes only where the tested code waits for it: in `sleep`, or in `select` while nothing has arrived.

Nobody else advances it, so no test depends on how busy the machine is. What is to happen meanwhile a test plans with
`at`; it happens within the wait that reaches its time. A sleep lasts as long as was asked for, and `oversleep` more.
"""

import heapq
import itertools
import select
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import pytest

_EPOCH = 1_700_000_000
"""Time of the host's clock at the beginning [s since the epoch]."""


class SimulatedTime:
    """Stands for the modules `time` and `select` in the tested code."""

    def __init__(self, oversleep: float = 0.0) -> None:
        """`oversleep`: what each sleep lasts too long [s]."""
        self.now = 100.0
        self._oversleep = oversleep
        self._planned: list[tuple[float, int, Callable[[], object]]] = []
        self._numbers = itertools.count()

    def at(self, delay: float, action: Callable[[], object]) -> None:
        """Plan an action `delay` [s] from now."""
        heapq.heappush(self._planned, (self.now + delay, next(self._numbers), action))

    def perf_counter(self) -> float:
        """Present time [s]."""
        return self.now

    monotonic = perf_counter

    def perf_counter_ns(self) -> int:
        """Present time [ns]."""
        return round(self.now * 1e9)

    def time(self) -> float:
        """Present time [s since the epoch]."""
        return _EPOCH + self.now

    def time_ns(self) -> int:
        """Present time [ns since the epoch]."""
        return _EPOCH * 10**9 + self.perf_counter_ns()

    def sleep(self, duration: float) -> None:
        """Wait for `duration` [s]."""
        end = self.now + duration + self._oversleep
        while self._step(end) < end:
            pass

    def select(self, *files_and_timeout: Any) -> tuple[Sequence[Any], ...]:
        """As `select.select`, with a timeout."""
        *files, timeout = files_and_timeout
        end = self.now + timeout
        while not any(ready := select.select(*files, 0)) and self.now < end:
            self._step(end)
        return ready

    def _step(self, end: float) -> float:
        """Go to `end` [s], or to the next planned action before it, and act; returns the time reached."""
        if self._planned and self._planned[0][0] <= end:
            due, _, action = heapq.heappop(self._planned)
            self.now = max(self.now, due)
            action()
        else:
            self.now = end
        return self.now


def simulate_time(monkeypatch: pytest.MonkeyPatch, *modules: ModuleType, oversleep: float = 0.0) -> SimulatedTime:
    """Give modules simulated time for the present test."""
    clock = SimulatedTime(oversleep)
    for module in modules:
        monkeypatch.setattr(module, "time", clock)
        if hasattr(module, "select"):
            monkeypatch.setattr(module, "select", clock)
    return clock
