"""Recording from the page: run `daq` as a separate process, read its status lines, stop it by a signal.

Nothing of `daq` is imported.
"""

import json
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ident.workbench.topics import Changes
from recordings.errors import BadInput
from recordings.rig import load_rig, simulated_rig

_MAX_CYCLES = 3000
"""Cycles kept for the live plots, at most."""
_MAX_LINES = 200
_UNATTENDED_TIMEOUT = 20.0
"""Time without a browser after which moving drives are stopped; long enough to reload the page [s]."""
_STOP_TIMEOUT = 10.0
"""Time for the drives to come to rest when the page closes [s]."""


@dataclass
class RunStatus:
    """Status of the recording in progress, or of the last one."""

    command: tuple[str, ...]
    file: Path
    position_unit: str = "rad"
    status: dict[str, Any] = field(default_factory=dict)
    rows: deque[dict[str, Any]] = field(default_factory=lambda: deque(maxlen=_MAX_CYCLES))
    """Cycles: time [s], command and position [`position_unit`], voltage [V]."""
    lateness: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MAX_CYCLES))
    """Time [s], and worst lateness since the previous entry [s]."""
    messages: deque[str] = field(default_factory=lambda: deque(maxlen=_MAX_LINES))
    """Lines that `daq` wrote to standard error."""
    stop_count: int = 0
    """Number of stop requests."""
    exit_code: int | None = None
    """Exit status; None while the process runs."""

    @property
    def has_rig_file(self) -> bool:
        """Whether a rig file was given; without one the drives are simulated."""
        return "--rig" in self.command


class RecordingProcess:
    """Runs at most one `daq record` at a time in the folder `root`."""

    def __init__(self, root: Path, changes: Changes) -> None:
        self._root, self._changes = root, changes
        self._process: subprocess.Popen[str] | None = None
        self.run: RunStatus | None = None
        self._last_seen = 0.0

    @property
    def running(self) -> bool:
        """Whether the process runs, so that drives may be moving."""
        return self._process is not None and self._process.poll() is None

    def mark_seen(self) -> None:
        """Note that a browser shows the page with its stop button now."""
        self._last_seen = time.monotonic()

    def start(self, options: Mapping[str, str], file: Path) -> None:
        """Start `daq record` with these `options` into the new file `file`.

        Raises:
            BadInput: a recording is in progress, the rig file is invalid, or the program `daq` is missing.
        """
        if self.running:
            raise BadInput("no other recording expected, one is in progress; stop it first")
        rig = load_rig(self._root / options["--rig"]) if "--rig" in options else simulated_rig()
        arguments = ("record", *command_line(options), "--status", "--out", file.name)
        # A new session: Ctrl-C in the terminal must not reach the process directly, as it is stopped by `close`.
        self._process = process = subprocess.Popen(
            [*daq_command(), *arguments],
            cwd=self._root,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.run = run = RunStatus(("daq", *arguments), file, rig.position_units[0])
        assert process.stderr is not None
        message_reader = threading.Thread(
            target=run.messages.extend, args=(map(str.rstrip, process.stderr),), daemon=True
        )
        message_reader.start()
        threading.Thread(target=self._read_status, args=(process, run, message_reader), daemon=True).start()
        self._changes.mark("run", "folder")

    def stop(self) -> None:
        """Ramp down along the motion and disable the drives; called again: quick stop."""
        if self._process is not None and self.run and self.running:
            self.run.stop_count += 1
            self._process.send_signal(signal.SIGTERM)
            self._changes.mark("run")

    def close(self) -> None:
        """Bring the drives to rest before the server ends. After the timeout the closed pipe stops them."""
        self.stop()
        try:
            if self._process is not None:
                self._process.wait(_STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self.stop()

    def _read_status(
        self, process: "subprocess.Popen[str]", run: RunStatus, message_reader: threading.Thread
    ) -> None:
        with process:
            assert process.stdout is not None
            for line in process.stdout:
                self._take_status(run, _parse_status(line))
            message_reader.join()  # all messages are read before the exit status is set
        run.exit_code = process.wait()
        self._changes.mark("run", "folder")

    def _take_status(self, run: RunStatus, status: dict[str, Any]) -> None:
        rows = status.pop("rows", [])
        run.rows.extend(rows)
        if rows and "lateness" in status:
            run.lateness.append((rows[-1]["time"], status["lateness"]))
        run.status = {**run.status, **status}
        if not run.stop_count and time.monotonic() - self._last_seen > _UNATTENDED_TIMEOUT:
            run.messages.append("no browser shows the page any more: stopping")
            self.stop()
        self._changes.mark("run")


def command_line(options: Mapping[str, str]) -> list[str]:
    """Return `options` as words of a command line."""
    return [word for option in options.items() for word in option]


def daq_command() -> list[str]:
    """Return the command of the `daq` that was installed together with this program.

    Raises:
        BadInput: it is not installed.
    """
    sibling = Path(sys.executable).with_name("daq")
    path = str(sibling) if sibling.exists() else shutil.which("daq")
    if path is None:
        raise BadInput("the program `daq` expected beside `ident`, none found; install delta-workbench as a whole")
    return [path]


def run_daq(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a short `daq` command, such as a pre-flight check, and return its output."""
    return subprocess.run(
        [*daq_command(), *arguments], cwd=root, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120
    )


def _parse_status(line: str) -> dict[str, Any]:
    try:
        parsed = json.loads(line)
    except ValueError:
        return {}
    return parsed if isinstance(parsed, dict) else {}
