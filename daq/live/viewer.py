"""Programs that show a run while it goes on: processes of their own, which the run never waits for."""

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

_BACKLOG = 1_000_000
"""Bytes that are kept for a viewer which does not read; lines beyond are dropped."""
PATIENCE = 10.0
"""How long a viewer may take to show the end of the run [s]."""
_LAST = 5.0
"""How much longer until it is ended [s]."""


class Viewer:
    """A module that reads a run line by line on its stdin, and ends with it; a context manager around the run.

    If it dies or is slow, the run goes on untouched.
    """

    def __init__(self, module: str, first: dict[str, Any], inherited: Sequence[int] = ()) -> None:
        """`first`: what it is told before all else; `inherited`: file descriptors that it goes on with."""
        # A session of its own: Ctrl-C in the terminal is for the run alone.
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            start_new_session=True,
            pass_fds=inherited,
        )
        assert self._process.stdin is not None
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        self._unsent = b""
        self.tell(json.dumps(first))

    def tell(self, line: str) -> None:
        """One more line. Returns at once; it is lost where the viewer reads nothing or has gone."""
        if len(self._unsent) < _BACKLOG:
            self._unsent += f"{line}\n".encode()
        self._send()

    def _send(self) -> None:
        try:
            self._unsent = self._unsent[os.write(self._pipe, self._unsent) :]
        except BlockingIOError:
            pass
        except BrokenPipeError:
            self._unsent = b""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Tell how the run ended, and wait until that has been shown; Ctrl-C cuts it short."""
        self.tell(json.dumps({"ended": None if error is None else str(error) or "interrupted"}))
        until = time.monotonic() + PATIENCE + _LAST
        with self._process:
            try:
                self._deliver(until)
                self._process.wait(until - time.monotonic())
            except (subprocess.TimeoutExpired, KeyboardInterrupt):
                self._process.kill()

    def _deliver(self, until: float) -> None:
        while self._unsent and time.monotonic() < until:
            select.select([], [self._pipe], [], 0.1)
            self._send()
        assert self._process.stdin is not None
        self._process.stdin.close()
