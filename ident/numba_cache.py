"""Compilation of the few loops that numpy cannot express, by numba, kept on disk for the next run."""

import warnings
from collections.abc import Callable
from typing import Any

import numba

_KNOWN: dict[tuple[Callable[..., Any], str], Callable[..., Any]] = {}


def compiled(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    """`function` compiled on its first call, with numba's `options`; the same one each time."""
    key = function, str(options)
    if key in _KNOWN:
        return _KNOWN[key]
    if options.get("parallel"):
        _start_threads()
    try:
        kept: Callable[..., Any] = numba.njit(cache=True, **options)(function)
    except RuntimeError:
        # Neither the package's folder nor the user's cache can be written: compile anew in every process.
        kept = numba.njit(**options)(function)
    _KNOWN[key] = kept
    return kept


def _start_threads() -> None:
    """Quietly: without /dev/shm numba warns that processes may get in each other's way as they start their threads,
    but those that we fork start none."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Could not obtain multiprocessing lock")
        numba.get_num_threads()
