"""Wait longer on a busy machine: one factor for the deadlines of tests and of the simulated rigs that they start.

`.ci/run` measures it once and hands it on in the environment. Limits of real drives, of safety, and those that a test
is about are never multiplied.

    export DELTA_WORKBENCH_PATIENCE=$(python -m tests.patience)
"""

import os
import time
from concurrent.futures import ProcessPoolExecutor

from drivers.patience import factor
from tests.timekeeping import LOOP_COUNT, LOOP_DURATION

_LARGEST = 10.0
_DURATION = 3.0
"""Time that is measured [s]."""


def patient(seconds: float) -> float:
    """A deadline of the test harness [s] on this machine."""
    return factor() * seconds


def measured(duration: float = _DURATION) -> float:
    """How many times longer than on a quiet machine of the usual speed work on all cores takes: 1 to 10."""
    cores = len(os.sched_getaffinity(0))
    with ProcessPoolExecutor(cores) as pool:
        slowness = sum(pool.map(_slowness, [duration] * cores)) / cores
    return min(max(slowness, 1.0), _LARGEST)


def _slowness(duration: float) -> float:
    """Wall time of the loops of one process in terms of what they usually take."""
    loops, start = 0, time.perf_counter()
    while (elapsed := time.perf_counter() - start) < duration:
        for _ in range(LOOP_COUNT):
            pass
        loops += 1
    return elapsed / (loops * LOOP_DURATION)


if __name__ == "__main__":
    print(f"{measured():.1f}")
