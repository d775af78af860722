"""Compute in processes of this machine, which are started anew when one of them dies."""

import multiprocessing
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait as wait_for
from typing import TypeVar

from ident.fleet.engines import ONE_THREAD, TRIES, EngineOptions, alone

T = TypeVar("T")
R = TypeVar("R")
_WINDOW = 4
"""Items per process that are given out in advance, so that none waits."""


def run(function: Callable[[T], R], items: Sequence[T], options: EngineOptions) -> Iterator[tuple[T, R | None]]:
    """See `Engine`. When a process dies, what it and the others had in work is done one by one, to find the cause."""
    waiting, suspected, deaths = list(range(len(items)))[::-1], list[int](), Counter[int]()
    while waiting or suspected:
        one_by_one = bool(suspected)
        window = 1 if one_by_one else _WINDOW * options.workers
        lost: list[int] = []
        batch = _until_broken(function, items, options.workers, suspected if one_by_one else waiting, window, lost)
        for index, result in batch:
            yield items[index], result
        if one_by_one:
            deaths.update(lost)
        for index in lost:
            if deaths[index] < TRIES:
                suspected.append(index)
            else:
                yield items[index], None


def _until_broken(
    function: Callable[[T], R], items: Sequence[T], workers: int, waiting: list[int], window: int, lost: list[int]
) -> Iterator[tuple[int, R]]:
    """Yield results until nothing is `waiting`, or a process died: what was in work is then added to `lost`."""
    pool = ProcessPoolExecutor(min(workers, window), multiprocessing.get_context("spawn"), _prepare_worker)
    running: dict[Future[R], int] = {}
    try:
        while waiting or running:
            while waiting and len(running) < window:
                index = waiting.pop()
                running[pool.submit(alone, function, items[index])] = index
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                result = future.result()
                yield running.pop(future), result
    except BrokenProcessPool:
        lost += running.values()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _prepare_worker() -> None:
    """Compute in one thread. Ctrl-C ends the program, which then ends its processes after the item in work."""
    os.environ.update(ONE_THREAD)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker when the program is killed: it holds both ends of the queue and would wait there for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for([parent.sentinel])
        os._exit(1)
