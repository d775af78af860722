"""Work that is shared among threads.

Numpy and the compiled kernels leave the interpreter to other threads while they work.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

_T = TypeVar("_T")

_STEP = 0.1
"""Longest time for which an interrupt waits [s]."""
_worker = threading.local()
"""Has an attribute in the threads that share the work."""


def in_threads(function: Callable[..., _T], *items: Iterable[Any]) -> list[_T]:
    """Return the results of `function` for all `items`, as `map` does, computed by one thread for each processor.

    The results are the same on any number of processors, if no call depends on another. In a call that is itself
    shared among threads, one thread computes all. After an error or an interrupt no further call begins.
    """
    arguments = list(zip(*items, strict=True))
    if len(arguments) < 2 or hasattr(_worker, "busy"):
        return [function(*values) for values in arguments]
    waiting, ended = deque(enumerate(arguments)), SimpleQueue[None]()
    results: dict[int, _T] = {}
    errors: dict[int, BaseException] = {}

    def work() -> None:
        while True:
            try:
                number, values = waiting.popleft()
            except IndexError:  # nothing is left
                break
            try:
                results[number] = function(*values)
            except BaseException as error:  # the caller gets it
                errors[number] = error
                waiting.clear()
        ended.put(None)

    tasks, count = _tasks()
    try:
        for _ in range(count):
            tasks.put(work)
        for _ in range(count):
            _get(ended)
    finally:
        waiting.clear()
    if errors:
        raise errors[min(errors)]
    return [results[number] for number in range(len(arguments))]


def compute_alone() -> None:
    """Let the calling thread compute all that it is asked for, because other processes use the other processors."""
    _worker.busy = True


def _get(ended: SimpleQueue[None]) -> None:
    """Wait for an item; in steps, since an interrupt that comes just before a wait does not end it."""
    while True:
        with suppress(Empty):
            return ended.get(timeout=_STEP)


@cache
def _tasks() -> tuple[SimpleQueue[Callable[[], None]], int]:
    """Queue of the threads that share the work, and their number.

    No executor: an interrupt in one of its conditions leaves that locked, and all threads wait for ever.
    """
    tasks, count = SimpleQueue[Callable[[], None]](), os.cpu_count() or 1

    def serve() -> None:
        compute_alone()
        while True:
            tasks.get()()

    for _ in range(count):
        threading.Thread(target=serve, daemon=True).start()
    return tasks, count


os.register_at_fork(after_in_child=_tasks.cache_clear)  # threads do not survive a fork
