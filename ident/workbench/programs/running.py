"""Run `daq` and `ident` as processes: the page never waits for their libraries, and imports nothing of `daq`."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from recordings.errors import BadInput

_TIMEOUT = 120.0
"""Longest time that a short command may take [s]."""
IDENT = (sys.executable, "-c", "from ident.cli import main; main()")
"""The command `ident` of this program."""


def daq_command() -> tuple[str, ...]:
    """Return the command of the `daq` that was installed together with this program.

    Raises:
        BadInput: it is not installed.
    """
    sibling = Path(sys.executable).with_name("daq")
    path = str(sibling) if sibling.exists() else shutil.which("daq")
    if path is None:
        raise BadInput("the program `daq` expected beside `ident`, none found; install delta-workbench as a whole")
    return (path,)


def run(
    root: Path, program: Iterable[str], words: Iterable[str], timeout: float | None = _TIMEOUT
) -> subprocess.CompletedProcess[str]:
    """Run `program` with `words` in the folder `root`, and return its output."""
    command = [*program, *words]
    return subprocess.run(
        command, cwd=root, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout
    )


def run_ident(root: Path, *words: str) -> str | None:
    """Run `ident` with `words` in the folder `root`, however long it takes; return the error that it ends with."""
    process = run(root, IDENT, words, timeout=None)
    if process.returncode == 0:
        return None
    reason = " ".join(errors(process.stderr.splitlines()))
    return reason or f"`ident {words[0]}` ended with exit status {process.returncode}"


def answer_of_daq(root: Path, *words: str) -> Mapping[str, Any]:
    """Return the document that `daq` with `words` and `--json` prints in the folder `root`.

    Raises:
        BadInput: it refuses what was given, or cannot be run.
    """
    try:
        process = run(root, daq_command(), (*words, "--json"))
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BadInput(f"an answer of `daq {words[0]}` expected, {error} found; run it in a terminal") from None
    if process.returncode:
        raise BadInput(" ".join(messages(process.stderr.splitlines())).removeprefix("error: "))
    document: Mapping[str, Any] = json.loads(process.stdout)
    return document


def messages(stderr: Iterable[str]) -> Iterator[str]:
    """Yield the lines of standard error without hints on the command line; errors begin with "error:"."""
    for line in map(str.rstrip, stderr):
        if line and not line.startswith(("Usage:", "Try '")):
            yield line.replace("Error:", "error:", 1) if line.startswith("Error:") else line


def errors(stderr: Iterable[str]) -> list[str]:
    """Return the errors among the lines of standard error."""
    return [line for line in messages(stderr) if line.startswith("error")]


def as_words(options: Mapping[str, str]) -> list[str]:
    """Return `options` as words of a command line."""
    return [word for option in options.items() for word in option]
