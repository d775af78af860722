"""Read damaged files of every kind, in processes of their own: each is read, or refused in a sentence, soon and in
little memory.
"""

import contextlib
import io
import multiprocessing
import resource
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from recordings.errors import BadInput, RunFailed
from tests.fuzz import originals
from tests.fuzz.damage import damaged

LONGEST, LARGEST = 60, 1000.0
"""Most processor time [s], which a busy machine does not lengthen, and memory [MB] that a file may take."""
_PATIENCE = 10 * LONGEST
"""By the clock; what does not answer for so long waits for something, or killed its process [s]."""


@dataclass(frozen=True)
class Outcome:
    """Of one damaged file, or one random recording."""

    seed: int
    kind: str
    refusal: str = ""
    """The sentence; or nothing."""
    failure: str = ""
    """A traceback; or that it took too long or too much; or nothing."""
    seconds: float = 0.0
    megabytes: float = 0.0
    """Largest memory of the process while a file was read."""


def attack(count: int, start: int, processes: int, kind: str = "") -> Iterator[Outcome]:
    """Read `count` damaged files of the kinds whose name holds `kind`; the seeds begin at `start`."""
    with tempfile.TemporaryDirectory() as name:
        kinds = {each: value for each, value in originals.kinds(Path(name)).items() if kind in each}
        _warm_up(kinds, Path(name))
        context = multiprocessing.get_context("fork")
        first, end = start, start + count
        while first < end:
            with context.Pool(processes, _start, (kinds, Path(name))) as pool:
                results = pool.imap(_attack, range(first, end))
                try:
                    while first < end:
                        first += 1
                        yield results.next(timeout=_PATIENCE)
                except multiprocessing.TimeoutError:  # it hangs outside of Python, or killed its process
                    yield Outcome(first - 1, "?", "", "no answer", _PATIENCE, 0.0)


def _warm_up(kinds: dict[str, originals.Kind], folder: Path) -> None:
    """Read the originals in all ways: they are whole, and what is imported or compiled takes its time now."""
    for name, kind in kinds.items():
        refusals = []
        for number, call in enumerate(kind.calls):
            with tempfile.TemporaryDirectory(dir=folder) as scratch:
                refusal, failure = _read(call, Path(shutil.copy(kind.original, scratch)))
            assert not failure, f"{name}, call {number}: {failure}"
            refusals.append(refusal)
        assert not all(refusals), f"{name}: {refusals}"  # a model of another form has no C


_kinds: dict[str, originals.Kind] = {}
_folder = Path()
_before = 0.0
"""Memory with which a process begins: that of the tests that ran before it [MB]."""


def _start(kinds: dict[str, originals.Kind], folder: Path) -> None:
    global _folder, _before
    _kinds.update(kinds)
    _folder, _before = folder, _peak()
    signal.signal(signal.SIGPROF, _too_long)


def _peak() -> float:
    """Most memory that this process had, what it began with included [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _too_long(*_: object) -> None:
    raise TimeoutError(f"more than {LONGEST} s")


def _attack(seed: int) -> Outcome:
    rng = np.random.default_rng(seed)
    name = list(_kinds)[seed % len(_kinds)]
    kind = _kinds[name]
    with tempfile.TemporaryDirectory(dir=_folder) as folder:
        path = Path(folder) / kind.original.name
        path.write_bytes(damaged(kind.original.read_bytes(), path.suffix, rng))
        call = kind.calls[int(rng.integers(len(kind.calls)))]
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        refusal, failure = _read(call, path)
        signal.setitimer(signal.ITIMER_PROF, 0)
    seconds, peak = time.process_time() - began, _peak() - _before
    if not failure and peak > LARGEST:
        failure = f"{peak:.0f} MB at {name}"
    return Outcome(seed, name, refusal, failure, seconds, peak)


def _read(call: Any, path: Path) -> tuple[str, str]:
    """Why the file is refused, and what failed."""
    silent = io.StringIO()
    with contextlib.redirect_stdout(silent), contextlib.redirect_stderr(silent):
        try:
            call(path)
        except (BadInput, RunFailed, click.ClickException, OSError) as error:
            return str(error) or "refused", ""
        except Exception:
            return "", traceback.format_exc()
    return "", ""
