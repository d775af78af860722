"""`ident watch` beside a run: a process that reads the file while it is written; its alarm becomes an event."""

import contextlib
import json
import os
import subprocess
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from daq.ident_program import IDENT
from drivers.protocol import Report

_SAMPLES = 50
"""Samples per second for a live view [Hz]."""
_NICE = 10
"""Lower priority than the run's."""
_END_TIMEOUT = 60.0
"""Longest time that the watch may take for what it has not read at the end of the run [s]."""
_ENVIRONMENT = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""One core is enough, and the run needs another."""


@dataclass(frozen=True)
class RunWatch:
    """That a run is watched, and what an alarm does."""

    model: Path
    stop_on_alarm: bool = False
    tell: Callable[[str], None] = lambda line: None
    """Gets each line, for viewers."""


class WatchProcess:
    """The process and the thread that reads its lines. The run never waits for it."""

    def __init__(self, watch: RunWatch, recording: Path, report: Report, stop: Callable[[str], None]) -> None:
        """Start to watch the `recording`; `report` gets the alarm, and `stop` the reason for a stop by it."""
        self._watch, self._report, self._stop = watch, report, stop
        self.reason: str | None = None
        """Why the run was asked to stop; None: it was not."""
        words = [*IDENT, "watch", str(watch.model), str(recording), "--follow", "--samples", str(_SAMPLES)]
        # In a separate session, so that Ctrl-C in the terminal reaches the run only.
        self._process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=os.environ | _ENVIRONMENT,
        )
        with contextlib.suppress(OSError):  # it may have ended already
            os.setpriority(os.PRIO_PROCESS, self._process.pid, _NICE)
        self._thread = threading.Thread(target=self._read, name="watch", daemon=True)
        self._thread.start()

    def finish(self) -> None:
        """Wait until it has read the recording, which is whole now; end it if that takes too long."""
        self._thread.join(_END_TIMEOUT)
        if self._thread.is_alive():
            self._report("warning", "watch", "the watch has not come to the end of the recording in time")
            self._process.kill()
            self._thread.join()

    def _read(self) -> None:
        with self._process as process:
            assert process.stdout is not None
            assert process.stderr is not None
            for line in process.stdout:
                content = json.loads(line)
                self._watch.tell(json.dumps({"watch": content}))
                if content["alarm"]:
                    self._alarm(content["alarm"])
            error = process.stderr.read().strip().splitlines()
        if process.returncode not in (0, 3):
            self._report("warning", "watch", f"the watch ended: {error[-1] if error else 'no reason given'}")

    def _alarm(self, alarm: dict[str, object]) -> None:
        text = f"alarm: {json.dumps(alarm)}"
        self._report("warning", "watch", text)
        if self._watch.stop_on_alarm:
            self.reason = f"stopped by {text}"
            self._stop(self.reason)
