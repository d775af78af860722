"""Real-time priority and locked memory for the cycle, where the operating system permits them."""

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from drivers.protocol import Report

_PRIORITY = 10
"""SCHED_FIFO priority of the cycle: above all ordinary programs, below the kernel's interrupt threads."""
_HELPER_PRIORITY = 1
"""SCHED_FIFO priority of the other threads of this program. They hold Python's global lock at times: if another
program preempted them then, the cycle would wait for that program."""
_MLOCK_FLAGS = 1 | 4
"""Flags of mlockall (MCL_CURRENT | MCL_ONFAULT): lock resident pages now, other mapped pages at first use."""


@contextmanager
def realtime_priority(report: Report) -> Iterator[None]:
    """Run the block with real-time priority (SCHED_FIFO) of the calling thread, lower real-time priority of the other
    threads of this program, and locked memory.

    Both are optional: `report` gets which of them are permitted. Threads started in the block have normal priority.
    """
    prioritized, locked = _raise_priority(), _lock_memory()
    report(
        "info",
        "host",
        f"{_permission_text('real-time priority', prioritized)}, {_permission_text('locked memory', locked)}",
    )
    try:
        yield
    finally:
        if prioritized:
            _schedule(os.SCHED_OTHER, 0, 0)
        if locked:
            ctypes.CDLL(None).munlockall()


def _permission_text(name: str, permitted: bool) -> str:
    return name if permitted else f"no {name} (not permitted)"


def _raise_priority() -> bool:
    try:
        _schedule(os.SCHED_FIFO, _PRIORITY, _HELPER_PRIORITY)
    except (AttributeError, OSError):  # another system, no permission
        return False
    return True


def _schedule(policy: int, priority: int, helper_priority: int) -> None:
    """Set the priorities of the calling thread and of all other threads; if that is not permitted, change none."""
    caller = threading.get_native_id()
    # The calling thread comes first: it needs the highest priority, so that a refusal changes no thread.
    for thread in sorted(
        (int(task.name) for task in Path("/proc/self/task").iterdir()), key=lambda thread: thread != caller
    ):
        with suppress(ProcessLookupError):  # the thread has ended
            parameters = os.sched_param(priority if thread == caller else helper_priority)
            os.sched_setscheduler(thread, policy | os.SCHED_RESET_ON_FORK, parameters)


def _lock_memory() -> bool:
    try:
        return bool(ctypes.CDLL(None).mlockall(_MLOCK_FLAGS) == 0)
    except (AttributeError, TypeError, OSError):  # another system
        return False
