"""Status of a run for other programs: ten JSON lines per second."""

import json
import math
import os
import signal
import sys
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from daq.cycle.background import BackgroundThread
from daq.cycle.progress import CycleProgress
from drivers.protocol import Sample

_INTERVAL = 0.1
"""Time between two lines [s]."""
_ROWS = 25
"""Largest number of cycles in a line, spread evenly over the cycles since the previous line."""


LineSink = Callable[[str], None]
"""Callback for one line."""


def to_stdout(line: str) -> None:
    """Print a line for the program that started this one. If that program has exited, nobody can stop the motion any
    more, so the run is ended as by Ctrl-C.
    """
    try:
        print(line, flush=True)
    except BrokenPipeError:
        # The rest of the buffer must not raise another error when the program ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        os.kill(os.getpid(), signal.SIGTERM)


class StatusLines(BackgroundThread):
    """Sender of status lines during a run. The cycle never waits for a receiver."""

    def __init__(self, progress: CycleProgress, rate: float, sink: LineSink) -> None:
        super().__init__("status")
        self._progress, self._rate, self._sink = progress, rate, sink
        self._previous_command: NDArray[np.float64] = np.array(math.nan)
        """Command of the previous cycle, which the drives must have reached now [rad]."""

    def _run_thread(self) -> None:
        while not self._finished.wait(_INTERVAL):
            self._send_status()
        self._send_status()

    def _send_status(self) -> None:
        progress = self._progress
        recent = [progress.recent.popleft() for _ in range(len(progress.recent))]
        reports = [progress.reports.popleft() for _ in range(len(progress.reports))]
        targets = [self._previous_command, *(command for _, command, _ in recent)]
        self._previous_command = targets.pop()
        late = progress.lateness[-max(1, len(recent)) :]
        shown = list(zip(targets, recent, strict=True))[:: -(-len(recent) // _ROWS) or 1]
        status = {
            "status": progress.phase,
            "done": progress.done,
            "total": progress.total,
            "cycles": progress.cycles,
            "answers_lost": progress.lost,
            "cycles_missed": progress.missed,
            "following_error_max": progress.following_error,
            "lateness": max(late, default=0.0),
            "reports": [": ".join(report) for report in reports],
            "rows": [_row(self._rate, target, *cycle) for target, cycle in shown],
        }
        self._sink(json.dumps(status, allow_nan=False))


def _row(
    rate: float, target: NDArray[np.float64], index: int, command: NDArray[np.float64], sample: Sample
) -> dict[str, Any]:
    """Build the row of one cycle; `target` is the command of the previous cycle. Values are null without a command or
    without an answer."""
    return {
        "time": index / rate,
        "command": _numbers(command.tolist()),
        "position": _numbers(sample.position),
        "following_error": _numbers((target - sample.position).tolist()),
        "voltage": _numbers(sample.voltage),
    }


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]
