"""Viewers of a run: separate processes, for which the run never waits."""

import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

_BACKLOG = 4_000_000
"""Largest number of bytes that are kept for a viewer that does not read, as while it starts: 30 s of lines of 10 kB.
Further lines are dropped."""
END_TIMEOUT = 60.0
"""Longest time that a viewer may take to show the end of the run [s]: a browser may be slow to start."""
_SOON = 2.0
"""Time after which it is said that a viewer is waited for [s]."""
_KILL_DELAY = 5.0
"""Additional time before the viewer is killed [s]."""


class Viewer:
    """Process that runs a viewer module and gets the status lines on its stdin; a context manager around the run.

    A viewer that exits or is slow does not affect the run.
    """

    def __init__(
        self,
        module: str,
        first: dict[str, Any],
        inherited: Sequence[int] = (),
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        """`first`: the first line, as an object; `inherited`: file descriptors that the process inherits.

        say: gets a sentence where the viewer is waited for in the end.
        """
        self._say = say
        # In a separate session, so that Ctrl-C in the terminal reaches the run only.
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
        self.send(json.dumps(first))

    def send(self, line: str, last: bool = False) -> None:
        """Send a line. Return at once; all but the `last` one are dropped if the viewer does not read."""
        if last or len(self._unsent) < _BACKLOG:
            self._unsent += f"{line}\n".encode()
        self._flush()

    def _flush(self) -> None:
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
        """Send the end of the run and wait until the viewer has shown it; Ctrl-C ends the wait."""
        self.send(json.dumps({"ended": None if error is None else str(error) or "interrupted"}), last=True)
        with self._process:
            try:
                if self._has_exited(_SOON):
                    return
                self._say("waiting until the live view has shown the end; Ctrl-C ends this")
                if not self._has_exited(END_TIMEOUT + _KILL_DELAY):
                    self._process.kill()
            except KeyboardInterrupt:
                self._process.kill()

    def _has_exited(self, timeout: float) -> bool:
        """Deliver what is unsent, and wait for the viewer to exit, for `timeout` [s] at most."""
        deadline = time.monotonic() + timeout
        while self._unsent and time.monotonic() < deadline:
            select.select([], [self._pipe], [], 0.1)
            self._flush()
        assert self._process.stdin is not None
        if not self._unsent:
            self._process.stdin.close()
        try:
            self._process.wait(max(deadline - time.monotonic(), 0.0))
        except subprocess.TimeoutExpired:
            return False
        return True
