"""Hold-to-run: a motion that goes on only while keep-alives arrive on an input, such as a key that is held."""

import os
import select
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from daq.cycle.background import BackgroundThread
from daq.cycle.progress import CycleProgress

TIMEOUT = 0.3
"""Longest time between two keep-alives while an axis moves [s]."""
START_TIMEOUT = 1.0
"""Longest time between two of them before: a keyboard repeats a key only after up to 0.7 s [s]."""
RELEASE = signal.SIGTERM
"""Signal that stops the run when the keep-alives end."""
_MOVING = ("approach", "stream")
_INTERVAL = 0.02
"""Time between two looks at the clock [s]."""
_CHUNK = 4096


class HoldToRun(BackgroundThread):
    """Watcher of the keep-alives of one run: anything read from `source` is one.

    Where they end, the run is stopped as by Ctrl-C, which ramps the motion down along its path; the end of the input
    is the end of the keep-alives. The cycle never waits for the input.
    """

    def __init__(self, progress: CycleProgress, source: int) -> None:
        """`source`: file descriptor."""
        super().__init__("hold")
        self._progress, self._source = progress, source
        self.released = False
        """Whether the keep-alives have ended."""

    def _run_thread(self) -> None:
        # What came before the run began says nothing about now. The end of the input stays.
        while select.select([self._source], [], [], 0)[0] and len(os.read(self._source, _CHUNK)) == _CHUNK:
            pass
        last = time.monotonic()
        while not self._finished.is_set():
            ready, _, _ = select.select([self._source], [], [], _INTERVAL)
            now = time.monotonic()
            if ready:
                if not os.read(self._source, _CHUNK):
                    break
                last = now
            elif now - last > (TIMEOUT if self._progress.phase in _MOVING else START_TIMEOUT):
                break
        if not self._finished.is_set():
            self.released = True
            os.kill(os.getpid(), RELEASE)


@contextmanager
def keys_unbuffered() -> Iterator[None]:
    """Read keys of a terminal at once, without Enter and without showing them; Ctrl-C still interrupts."""
    if not sys.stdin.isatty():
        yield
        return
    import termios
    import tty

    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
