"""Compilation by numba of the few loops that numpy cannot express, cached on disk."""

import warnings
from collections.abc import Callable
from types import FunctionType
from typing import Any

import numba

_COMPILED: dict[tuple[Callable[..., Any], str], Any] = {}


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """Return `function`, and what it calls, compiled with numba's `options` on its first call; the same each time.

    The functions that it calls by their names stay functions of Python beside that. Threads may run it at the same
    time: it does not hold the interpreter's lock.
    """
    key = function, str(options)
    if key in _COMPILED:
        return _COMPILED[key]
    if options.get("parallel"):
        _start_threads()
    names, known = function.__code__.co_names, function.__globals__
    called = {name: compiled(known[name], **options) for name in names if isinstance(known.get(name), FunctionType)}
    twin = FunctionType(function.__code__, {**known, **called}, function.__name__, None, function.__closure__)
    twin.__qualname__, twin.__module__ = function.__qualname__, function.__module__
    try:
        jitted: Any = numba.njit(cache=True, nogil=True, error_model="numpy", **options)(twin)
        # numba looks at the file of the function alone, and would keep what was compiled of others.
        files = [jitted._cache._cache_file, *(each._cache._cache_file for each in called.values())]  # noqa: SLF001
        files[0]._source_stamp = tuple(file._source_stamp for file in files)  # noqa: SLF001
    except RuntimeError:
        # Neither the package's folder nor the user's cache is writable: compile in every process.
        jitted = numba.njit(nogil=True, error_model="numpy", **options)(twin)
    _COMPILED[key] = jitted
    return jitted


def _start_threads() -> None:
    """Start numba's threads without its warning where /dev/shm is missing.

    The warning is about processes that start threads at the same time; our forked processes start none.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Could not obtain multiprocessing lock")
        numba.get_num_threads()
