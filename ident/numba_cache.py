"""Compilation by numba of the few loops that numpy cannot express, cached on disk."""

import warnings
from collections.abc import Callable
from typing import Any

import numba

_COMPILED: dict[tuple[Callable[..., Any], str], Callable[..., Any]] = {}


def compiled(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """Return `function` compiled with numba's `options` on its first call; the same object each time.

    Threads may run it at the same time: it does not hold the interpreter's lock.
    """
    key = function, str(options)
    if key in _COMPILED:
        return _COMPILED[key]
    if options.get("parallel"):
        _start_threads()
    try:
        jitted: Callable[..., Any] = numba.njit(cache=True, nogil=True, **options)(function)
    except RuntimeError:
        # Neither the package's folder nor the user's cache is writable: compile in every process.
        jitted = numba.njit(nogil=True, **options)(function)
    _COMPILED[key] = jitted
    return jitted


def _start_threads() -> None:
    """Start numba's threads without its warning where /dev/shm is missing.

    The warning is about processes that start threads at the same time; our forked processes start none.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Could not obtain multiprocessing lock")
        numba.get_num_threads()
