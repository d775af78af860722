"""Whether this machine keeps time while a test runs.

What a test shows about contents must not depend on it. What it shows about time means something only on a machine
that wakes a sleeping process when it is due, so it is measured, by a process that does nothing else:

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
"""A machine that keeps time is never later than this [s], 99 times of 100 not later than this [s], and not so many
times slower than the machine for which the rates in the tests were chosen."""

_TURNS, _TURNS_TAKE = 20_000, 20_000 * 14e-9
"""Turns of an empty loop in each step, and how long they take on that machine [s]."""


@dataclass
class Machine:
    """How this machine kept time. The figures are there when the block of `watched` has ended."""

    worst: float = 0.0
    usual: float = 0.0
    slowness: float = 0.0

    @property
    def keeps_time(self) -> bool:
        """Whether something shown about time means something."""
        return self.worst <= WORST and self.usual <= USUAL and self.slowness <= SLOWNESS

    def expect(self, holds: bool, otherwise: str) -> None:
        """Fail where something about time does not hold; skip the rest where this machine does not keep time."""
        if holds:
            return
        import pytest  # not in the process that watches

        if self.keeps_time:
            pytest.fail(f"{otherwise}\n(this machine keeps time: {self})")
        last = next(reversed(otherwise.strip().splitlines()), "")
        pytest.skip(f"this machine does not keep time: {self}. So nothing follows from: {last}")

    def __str__(self) -> str:
        return (
            f"sleeps end up to {1e3 * self.worst:.0f} ms late (allowed: {1e3 * WORST:.0f}), 99 % of them "
            f"{1e3 * self.usual:.1f} ms ({1e3 * USUAL:g}); {self.slowness:.1f} times slower than usual ({SLOWNESS:g})"
        )


@contextmanager
def watched(step: float = 0.005) -> Iterator[Machine]:
    """Watch the machine during a block, every `step` [s], for 0.3 ms. The figures are there also where it fails."""
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
    """Sleep and compute in small steps until SIGTERM; print how late the worst and the 99th of 100 steps began [s],
    and how many times slower than usual the computing went."""
    over: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: over.append(number))
    print("watching", flush=True)
    late: list[float] = []
    took: list[float] = []
    while not over or not late:
        slept = time.perf_counter()
        time.sleep(step)
        woken = time.perf_counter()
        for _ in range(_TURNS):
            pass
        late.append(max(0.0, woken - slept - step))
        took.append(time.perf_counter() - woken)
    # A stall while it computes is a stall.
    stalls = [delay + max(0.0, duration - 4 * _TURNS_TAKE) for delay, duration in zip(late, took, strict=True)]
    print(max(stalls), sorted(stalls)[int(0.99 * len(stalls))], sum(took) / len(took) / _TURNS_TAKE)


if __name__ == "__main__":
    _watch(float(sys.argv[1]))
