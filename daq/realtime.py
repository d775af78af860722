"""Precedence of the cycle over other programs, where this computer permits it."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager

from drivers.protocol import Report

_PRIORITY = 10
"""Of SCHED_FIFO: above all ordinary programs, below the kernel's own interrupt threads."""
_CURRENT_ON_FAULT = 1 | 4
"""For mlockall: what is in memory, and what comes to be of that which is mapped; no limit of later allocations."""


@contextmanager
def precedence(report: Report) -> Iterator[None]:
    """Meanwhile the calling thread goes first (SCHED_FIFO) and this program's memory is not swapped.

    Neither is needed: `report` gets which of both this computer permits. Threads begun meanwhile are ordinary ones.
    """
    first, locked = _go_first(), _lock_memory()
    report("info", "host", f"{_words('real-time priority', first)}, {_words('locked memory', locked)}")
    try:
        yield
    finally:
        if first:
            os.sched_setscheduler(0, os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, os.sched_param(0))
        if locked:
            ctypes.CDLL(None).munlockall()


def _words(name: str, permitted: bool) -> str:
    return name if permitted else f"no {name} (not permitted)"


def _go_first() -> bool:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(_PRIORITY))
    except (AttributeError, OSError):  # another system, no permission
        return False
    return True


def _lock_memory() -> bool:
    try:
        return bool(ctypes.CDLL(None).mlockall(_CURRENT_ON_FAULT) == 0)
    except (AttributeError, TypeError, OSError):  # another system
        return False
