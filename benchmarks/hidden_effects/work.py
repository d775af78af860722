"""Process many cases in parallel, with progress, and store the results; can be interrupted and continued."""

import json
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Protocol, TypeVar


class Task(Protocol):
    """What can be processed."""

    @property
    def name(self) -> str:
        """Shown when it is done."""


C = TypeVar("C", bound=Task)
T = TypeVar("T")


@contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM end the block, and the program, with the word that the same command continues."""
    # A shell makes background processes ignore Ctrl-C.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    except KeyboardInterrupt:
        print("stopped; the same command continues", file=sys.stderr)
        raise SystemExit(1) from None


def run_all(
    task: Callable[[C], T], todo: Sequence[C], jobs: int, what: str, summary: Callable[[T], str] = str
) -> Iterator[T]:
    """Yield the result of `task` for each case, in order of completion."""
    # One process per job: multithreaded libraries would compete for the cores.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL", "NUMBA")})
    start = time.monotonic()
    with get_context("spawn").Pool(jobs, _ignore_interrupts) as pool:
        results = pool.imap_unordered(partial(_with_case, task), todo)
        for done, (case, result) in enumerate(results, start=1):
            remaining = (time.monotonic() - start) / done * (len(todo) - done)
            print(
                f"{what} {done}/{len(todo)}, {remaining / 60:.0f} min left: {case.name}: {summary(result)}",
                flush=True,
            )
            yield result


def _with_case(task: Callable[[C], T], case: C) -> tuple[C, T]:
    return case, task(case)


def _ignore_interrupts() -> None:
    """Ignore Ctrl-C, which reaches all processes: the parent process stops the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class Answers:
    """The file of results in a folder: JSON lines, each with its case and the version that answered (engine)."""

    def __init__(self, root: Path) -> None:
        self._path = root / "diagnoses.jsonl"

    def of(self, engine: str) -> dict[str, dict[str, Any]]:
        """Stored lines of an `engine`, by name of the case."""
        return {line["case"]: line for line in self._lines() if line["engine"] == engine}

    def last_engine(self) -> str | None:
        """Engine of the last stored line."""
        return next((line["engine"] for line in reversed(self._lines())), None)

    def append(self, line: dict[str, Any]) -> None:
        """Store a line."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")

    def completed(
        self,
        engine: str,
        cases: Sequence[Task],
        task: Callable[[Any], dict[str, Any]],
        jobs: int,
        summary: Callable[[dict[str, Any]], str],
    ) -> dict[str, dict[str, Any]]:
        """Lines of an `engine` by name, after those of `cases` that were missing were made by `task` and stored."""
        known = self.of(engine)
        todo = [case for case in cases if case.name not in known]
        for line in run_all(task, todo, jobs, "diagnose", summary):
            self.append(line)
        return self.of(engine)

    def _lines(self) -> list[dict[str, Any]]:
        if not self._path.exists():
            return []
        return [json.loads(line) for line in self._path.read_text(encoding="utf-8").splitlines()]
