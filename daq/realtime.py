"""Precedence of the cycle over other programs, where this computer permits it."""

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from drivers.protocol import Report

_PRIORITY = 10
"""Of SCHED_FIFO: above all ordinary programs, below the kernel's own interrupt threads."""
_HELPERS = 1
"""Of this program's other threads. They hold Python's lock at times: if another program came before them just then,
the cycle would wait for that program."""
_CURRENT_ON_FAULT = 1 | 4
"""For mlockall: what is in memory, and what comes to be of that which is mapped; no limit of later allocations."""


@contextmanager
def precedence(report: Report) -> Iterator[None]:
    """Meanwhile the calling thread goes first (SCHED_FIFO), this program's other threads come next, and its memory is
    not swapped.

    Neither is needed: `report` gets which of both this computer permits. Threads begun meanwhile are ordinary ones.
    """
    first, locked = _go_first(), _lock_memory()
    report("info", "host", f"{_words('real-time priority', first)}, {_words('locked memory', locked)}")
    try:
        yield
    finally:
        if first:
            _schedule(os.SCHED_OTHER, 0, 0)
        if locked:
            ctypes.CDLL(None).munlockall()


def _words(name: str, permitted: bool) -> str:
    return name if permitted else f"no {name} (not permitted)"


def _go_first() -> bool:
    try:
        _schedule(os.SCHED_FIFO, _PRIORITY, _HELPERS)
    except (AttributeError, OSError):  # another system, no permission
        return False
    return True


def _schedule(policy: int, priority: int, helper_priority: int) -> None:
    """Give the calling thread and all others of this program these priorities; if it may not, none of them."""
    me = threading.get_native_id()
    # The calling thread, which asks for the most, is the first.
    for thread in sorted(
        (int(task.name) for task in Path("/proc/self/task").iterdir()), key=lambda thread: thread != me
    ):
        with suppress(ProcessLookupError):  # it has ended meanwhile
            parameters = os.sched_param(priority if thread == me else helper_priority)
            os.sched_setscheduler(thread, policy | os.SCHED_RESET_ON_FORK, parameters)


def _lock_memory() -> bool:
    try:
        return bool(ctypes.CDLL(None).mlockall(_CURRENT_ON_FAULT) == 0)
    except (AttributeError, TypeError, OSError):  # another system
        return False
