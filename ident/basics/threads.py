"""Work that is shared among threads.

Numpy and the compiled kernels leave the interpreter to other threads while they work.
"""

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

_T = TypeVar("_T")

_worker = threading.local()
"""Has an attribute in the threads of the pool."""


def in_threads(function: Callable[..., _T], *items: Iterable[Any]) -> list[_T]:
    """Return the results of `function` for all `items`, as `map` does, computed by one thread for each processor.

    The results are the same on any number of processors, if no call depends on another. In a call that is itself
    shared among threads, one thread computes all.
    """
    arguments = list(zip(*items, strict=True))
    if len(arguments) < 2 or hasattr(_worker, "busy"):
        return [function(*values) for values in arguments]
    return list(_pool().map(lambda values: function(*values), arguments))


def compute_alone() -> None:
    """Let the calling thread compute all that it is asked for, because other processes use the other processors."""
    _worker.busy = True


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count(), initializer=compute_alone)


os.register_at_fork(after_in_child=_pool.cache_clear)  # threads do not survive a fork
