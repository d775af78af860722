"""Process many cases in parallel, with progress; can be interrupted."""

import os
import signal
import time
from collections.abc import Callable, Generator, Sequence
from functools import partial
from multiprocessing import get_context
from typing import Protocol, TypeVar


class Task(Protocol):
    """What can be processed."""

    @property
    def name(self) -> str:
        """Shown when it is done."""


C = TypeVar("C", bound=Task)
T = TypeVar("T")


def run_all(
    task: Callable[[C], T], todo: Sequence[C], jobs: int, what: str, summary: Callable[[T], str] = str
) -> Generator[T, None, None]:
    """Yield the result of `task` for each case, in order of completion. Closing the generator stops running tasks."""
    # One process per job: multithreaded libraries would compete for the cores.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL", "NUMBA")})
    start = time.monotonic()
    with get_context("spawn").Pool(jobs, _ignore_interrupts) as pool:
        results = pool.imap_unordered(partial(_with_case, task), todo)
        for done, (case, result) in enumerate(results, start=1):
            remaining = (time.monotonic() - start) / done * (len(todo) - done)
            print(
                f"{what} {done}/{len(todo)}, {remaining / 60:.0f} min left: {case.name}: {summary(result)}",
                flush=True,
            )
            yield result


def _with_case(task: Callable[[C], T], case: C) -> tuple[C, T]:
    return case, task(case)


def _ignore_interrupts() -> None:
    """Ignore Ctrl-C, which reaches all processes: the parent process stops the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
