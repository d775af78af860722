"""A Dask scheduler and workers that are started by hand, as on several machines: joined over TCP, by a file."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ident.fleet.engines import EngineOptions
from recordings.errors import RunFailed

_PATIENCE = 120.0
"""Time in which a scheduler has to start [s]."""
_GRACE = 30.0
"""Time in which a process has to end by itself [s]."""
_SETTINGS = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__INTERVAL": "1s",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
    "DASK_DISTRIBUTED__WORKER__MEMORY__MONITOR_INTERVAL": "500ms",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "2s",
}
"""As docs/how-to/watch-a-fleet.md says."""
_Process = subprocess.Popen[bytes]


@dataclass(frozen=True, eq=False)
class Cluster:
    """A running scheduler and its workers."""

    options: EngineOptions
    """To compute on it."""
    scheduler: _Process
    workers: tuple[_Process, ...]


@contextmanager
def started(workers: int) -> Iterator[Cluster]:
    """Start a scheduler and so many workers, and end them at the end of the block."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        common = ["--scheduler-file", str(file), "--no-dashboard"]
        processes = [_start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", *common)]
        try:
            end = time.monotonic() + _PATIENCE
            while not file.exists():
                if time.monotonic() > end:
                    raise RunFailed(f"the scheduler has not started within {_PATIENCE:.0f} s")
                time.sleep(0.1)
            processes += [_start("dask_worker", *common, "--nthreads", "1") for _ in range(workers)]
            yield Cluster(EngineOptions(scheduler_file=file), processes[0], tuple(processes[1:]))
        finally:
            for process in processes[::-1]:
                _end(process)


def _end(process: _Process) -> None:
    process.terminate()
    try:
        process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _start(module: str, *arguments: str) -> _Process:
    command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
    return subprocess.Popen(command, env=os.environ | _SETTINGS, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
