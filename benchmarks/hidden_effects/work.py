"""Doing something to many cases, in several processes, with progress; it can be stopped."""

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from multiprocessing import get_context
from typing import TypeVar

from benchmarks.hidden_effects.cases import Case

T = TypeVar("T")


def over(
    task: Callable[[Case], T], todo: Sequence[Case], jobs: int, what: str, say: Callable[[T], str] = str
) -> Iterator[T]:
    """Results in the order in which they come. What has been begun is given up when this is left early."""
    # One process per job; libraries with threads of their own would only be in each other's way.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL", "NUMBA")})
    start = time.monotonic()
    with get_context("spawn").Pool(jobs, _ignore_interrupts) as pool:
        results = pool.imap_unordered(partial(_with_case, task), todo)
        for done, (case, result) in enumerate(results, start=1):
            remaining = (time.monotonic() - start) / done * (len(todo) - done)
            print(f"{what} {done}/{len(todo)}, {remaining / 60:.0f} min left: {case.name}: {say(result)}", flush=True)
            yield result


def _with_case(task: Callable[[Case], T], case: Case) -> tuple[Case, T]:
    return case, task(case)


def _ignore_interrupts() -> None:
    """Ctrl-C reaches all processes; the first one sees to the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
