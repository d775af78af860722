"""Measure whether this machine keeps time while a test runs.

Tests of contents must not depend on timing. Tests of timing are valid only on a machine that wakes sleeping processes
in time, which a separate process measures:

    with timekeeping.watched() as machine:
        done = daq("record", "--pace", "realtime", ...)
    machine.expect(done.code == 0, done.err)
"""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

WORST, USUAL, SLOWNESS = 0.1, 0.002, 2.0
"""Limits of a machine that keeps time: largest delay of a wake-up [s], 99 % quantile of the delays [s], and slowness
relative to the machine for which the rates in the tests were chosen."""

LOOP_COUNT, LOOP_DURATION = 20_000, 20_000 * 14e-9
"""Iterations of an empty loop in each step, and their duration on that machine [s]."""

NO_TIME = "this machine does not keep time"
"""Reason of a skip."""


@dataclass
class Machine:
    """Timekeeping of this machine; complete when the block of `watched` has ended."""

    worst: float = 0.0
    usual: float = 0.0
    slowness: float = 0.0

    @property
    def keeps_time(self) -> bool:
        """Whether tests of timing are valid."""
        return self.worst <= WORST and self.usual <= USUAL and self.slowness <= SLOWNESS

    def expect(self, holds: bool, otherwise: str) -> None:
        """If a condition on timing does not hold, fail; on a machine that does not keep time, skip instead."""
        if holds:
            return
        import pytest  # not needed in the measuring process

        from tests.failures import Mistimed

        if self.keeps_time:
            raise Mistimed(f"{otherwise}\n(this machine keeps time: {self})")
        last_line = next(reversed(otherwise.strip().splitlines()), "")
        pytest.skip(f"{NO_TIME}: {self}. So nothing follows from: {last_line}")

    def __str__(self) -> str:
        return (
            f"sleeps end up to {1e3 * self.worst:.0f} ms late (allowed: {1e3 * WORST:.0f}), 99 % of them "
            f"{1e3 * self.usual:.1f} ms ({1e3 * USUAL:g}); {self.slowness:.1f} times slower than usual ({SLOWNESS:g})"
        )


@contextmanager
def watched(step: float = 0.005) -> Iterator[Machine]:
    """Measure the timekeeping during a block, every `step` [s] for 0.3 ms, also if the block fails."""
    machine = Machine()
    command = [sys.executable, "-S", "-E", __file__, str(step)]
    watcher = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert watcher.stdout is not None
    assert watcher.stdout.readline() == "watching\n"
    try:
        yield machine
    finally:
        watcher.send_signal(signal.SIGTERM)
        out, _ = watcher.communicate(timeout=60)
        machine.worst, machine.usual, machine.slowness = map(float, out.split())


def _watch(step: float) -> None:
    """Sleep and compute in small steps until SIGTERM; print the timekeeping.

    The numbers are the largest delay and the 99 % quantile of the delays [s], and the slowness of the computation.
    """
    stop_signals: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: stop_signals.append(number))
    print("watching", flush=True)
    delays: list[float] = []
    durations: list[float] = []
    while not stop_signals or not delays:
        sleep_start = time.perf_counter()
        time.sleep(step)
        sleep_end = time.perf_counter()
        for _ in range(LOOP_COUNT):
            pass
        delays.append(max(0.0, sleep_end - sleep_start - step))
        durations.append(time.perf_counter() - sleep_end)
    # A stall during the computation counts, too.
    stalls = [
        delay + max(0.0, duration - 4 * LOOP_DURATION) for delay, duration in zip(delays, durations, strict=True)
    ]
    print(max(stalls), sorted(stalls)[int(0.99 * len(stalls))], sum(durations) / len(durations) / LOOP_DURATION)


if __name__ == "__main__":
    _watch(float(sys.argv[1]))
