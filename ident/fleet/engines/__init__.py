"""Engines that apply a function to many items: in this process, in local processes, or on a Dask cluster.

Each is a module with a function `run`; the results are the same with any of them, in any order.
"""

import ctypes
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Protocol, TypeVar

from ident.basics import plugins
from ident.basics.threads import compute_alone

T = TypeVar("T")
R = TypeVar("R")
TRIES = 3
"""Number of workers that may die over an item before it counts as failed."""
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""Environment of a local worker. Numba refuses another number once its threads run: never set it in this process."""

_KEPT = {-1: 256 * 2**20, -3: 32 * 2**20}
"""Options of `mallopt` of the GNU C library [bytes]: unused memory that stays with the process, M_TRIM_THRESHOLD, and
size from which an array is returned at once, M_MMAP_THRESHOLD."""


@dataclass(frozen=True)
class EngineOptions:
    """Where to compute."""

    workers: int = 1
    scheduler: str | None = None
    """Address of a running Dask scheduler."""
    scheduler_file: Path | None = None
    """File in which a running Dask scheduler wrote its address."""
    say: Callable[[str], None] = lambda text: None
    """Receives the address of the dashboard."""


class Engine(Protocol):
    """Interface of the modules in this folder."""

    def run(
        self, function: Callable[[T], R], items: Sequence[T], options: EngineOptions
    ) -> Iterator[tuple[T, R | None]]:
        """Yield each item with the result of `function`, as soon as it is there; None if its workers died."""


def names() -> tuple[str, ...]:
    """Names of the engines."""
    return plugins.names(__name__)


def load(name: str) -> Engine:
    """Return the engine `name`."""
    return import_module(f"{__name__}.{name}")


def alone(function: Callable[[T], R], item: T) -> R:
    """Apply `function` in a worker: in one thread, because the other workers use the other processors."""
    compute_alone()
    _keep_freed_memory()
    return function(item)


@cache
def _keep_freed_memory() -> None:
    """Let this process keep some of the memory that it has freed, as it will need as much for the next item.

    Dask has its workers return all beyond 64 KiB at once (MALLOC_TRIM_THRESHOLD_), so that every array comes as new
    pages, which the kernel clears: a quarter of the time of a recording.
    """
    set_option = getattr(ctypes.CDLL(None), "mallopt", None)
    if set_option is not None:  # other C libraries have none
        for option, size in _KEPT.items():
            set_option(option, size)
