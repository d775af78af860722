"""Doing something to many cases, in several processes, with progress; it can be stopped."""

import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

from benchmarks.hidden_effects.cases import Case

T = TypeVar("T")


def over(
    task: Callable[[Case], T], todo: Sequence[Case], jobs: int, what: str, say: Callable[[T], str] = str
) -> Iterator[tuple[Case, T]]:
    """Results in the order in which they come. Ctrl-C waits for nothing but what has been begun."""
    # One process per job; libraries with threads of their own would only be in each other's way.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL", "NUMBA")})
    start = time.monotonic()
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_ignore_interrupts)
    futures = {pool.submit(task, case): case for case in todo}
    try:
        for done, future in enumerate(as_completed(futures), start=1):
            case, result = futures[future], future.result()
            left = (time.monotonic() - start) / done * (len(todo) - done)
            print(f"{what} {done}/{len(todo)}, {left / 60:.0f} min left: {case.name}: {say(result)}", flush=True)
            yield case, result
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
