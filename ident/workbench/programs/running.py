"""Run `daq` and `ident` as processes: the page never waits for their libraries, and imports nothing of `daq`."""

import json
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextvars import ContextVar, copy_context
from pathlib import Path
from typing import Any, TypeVar

from recordings.errors import BadInput

_TIMEOUT = 900.0
"""Longest time that a command may take on a busy machine [s]: an import waits for `ident check`."""
_IDENT = (sys.executable, "-c", "from ident.cli import main; main()")
"""The command `ident` of this program."""

_OPTION = re.compile(r"(?<!\S)--?[a-z]|ident\.\w+\(")

Result = TypeVar("Result")


class Cancellable:
    """An action of the page, in a thread of its own, whose programs can be ended."""

    def __init__(self) -> None:
        self.text = "working"
        """Program that runs, for the user."""
        self.cancelled = False
        self._process: subprocess.Popen[str] | None = None

    def call(self, action: Callable[..., Result], *arguments: Any) -> Result:
        """Return what `action` returns."""
        context = copy_context()
        context.run(_ACTION.set, self)
        return context.run(action, *arguments)

    def cancel(self) -> None:
        """End the program as Ctrl-C does: it removes what it has written half, and stops drives."""
        self.cancelled = True
        if self._process is not None:  # Windows can ask a program only together with this one: it is ended at once
            self._process.send_signal(signal.SIGTERM if sys.platform == "win32" else signal.SIGINT)

    def runs(self, process: "subprocess.Popen[str]", text: str) -> None:
        """Let `cancel` end the `process`."""
        self._process, self.text = process, text
        if self.cancelled:
            self.cancel()

    def check(self) -> None:
        """Raise BadInput if the action was cancelled."""
        if self.cancelled:
            raise BadInput(f"Cancelled ({self.text}).")


_ACTION: ContextVar[Cancellable | None] = ContextVar("action", default=None)


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
    """Run `program` with `words` in the folder `root`, and return its output.

    Raises:
        BadInput: the action that has asked for it was cancelled.
    """
    words, pipe, action = [*words], subprocess.PIPE, _ACTION.get() or Cancellable()
    command = [*program, *words]
    with subprocess.Popen(
        command, cwd=root, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True
    ) as process:
        action.runs(process, words[0])
        try:
            out, err = process.communicate(timeout=timeout)
        except BaseException:
            process.kill()
            raise
    action.check()
    return subprocess.CompletedProcess(command, process.returncode, out, err)


def printed_by(root: Path, program: str, *words: str) -> str:
    """Run `program`, which is ident or daq, in the folder `root`, however long it takes; return all that it prints.

    Raises:
        BadInput: it ends with an error.
    """
    process = run(root, _IDENT if program == "ident" else daq_command(), words, timeout=None)
    if process.returncode:
        reason = " ".join(errors(process.stderr.splitlines()))
        raise BadInput(reason or f"`{program} {words[0]}` ended with exit status {process.returncode}")
    return process.stdout + process.stderr


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
    return json.loads(process.stdout)


def without_options(said: str) -> str:
    """Return an error without the hints that name options or functions: the page has none."""
    return "; ".join(part for part in said.split("; ") if not _OPTION.search(part)) or said


def messages(stderr: Iterable[str]) -> Iterator[str]:
    """Yield the lines of standard error without hints on the command line; errors begin with "error:"."""
    for line in map(str.rstrip, stderr):
        if line and not line.startswith(("Usage:", "Try '")):
            yield re.sub(r"^Error: (Invalid value for '--(\S+)'(?=:))?", r"error: \2", line)


def errors(stderr: Iterable[str]) -> list[str]:
    """Return the errors among the lines of standard error."""
    return [line for line in messages(stderr) if line.startswith("error")]


def as_words(options: Mapping[str, str]) -> list[str]:
    """Return `options` as words of a command line."""
    return [word for option in options.items() for word in option]
