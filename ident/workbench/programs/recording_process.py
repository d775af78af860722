"""Motion from the page: run `daq` as a separate process, read its status lines, stop it by a signal."""

import json
import signal
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from ident.workbench.programs.running import as_words, daq_command, errors, messages
from ident.workbench.topics import Changes
from recordings.errors import BadInput
from recordings.rig import Rig, load_rig, simulated_rig

_MAX_CYCLES = 3000
"""Cycles kept for the live plots, at most."""
_MAX_LINES = 200
_UNATTENDED_TIMEOUT = 20.0
"""Time without a browser after which moving drives are stopped; long enough to reload the page [s]."""
_BROWSER_INTERVAL = 0.2
"""Time between two looks whether a browser shows the page [s]."""
_TOLD_INTERVAL = 0.5
"""Time between two updates of the live plots [s]."""
_STOP_TIMEOUT = 10.0
"""Time for the drives to come to rest when the page closes [s]."""


@dataclass
class RunStatus:
    """Status of the run in progress, or of the last one.

    Other threads append to its queues, so a copy is what can be gone through.
    """

    command: tuple[str, ...]
    file: Path | None
    """The recording; None where none is kept."""
    position_unit: str = "rad"
    joint: int = 1
    """Joint that moves, where only one does."""
    status: dict[str, Any] = field(default_factory=dict)
    rows: deque[dict[str, Any]] = field(default_factory=lambda: deque(maxlen=_MAX_CYCLES))
    """Cycles: time [s], command and position [`position_unit`], voltage [V]."""
    lateness: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_MAX_CYCLES))
    """Time [s], and worst lateness since the previous entry [s]."""
    messages: deque[str] = field(default_factory=lambda: deque(maxlen=_MAX_LINES))
    """Lines that `daq` wrote for people."""
    stop_count: int = 0
    """Number of stop requests."""
    exit_code: int | None = None
    """Exit status; None while the process runs."""

    @property
    def has_rig_file(self) -> bool:
        """Whether a rig file was given; without one the drives are simulated."""
        return "--rig" in self.command

    @property
    def reason(self) -> str:
        """Why the process ended early."""
        return next(iter(errors(reversed(list(self.messages)))), f"exit status {self.exit_code}")

    @property
    def name(self) -> str:
        """Name of the file, or of the command."""
        return self.file.name if self.file else " ".join(self.command[:2])

    def latest(self, kind: str) -> float | None:
        """Last "position" or "following_error" of `joint`; None where it is not known."""
        values = [row[kind][self.joint - 1] for row in list(self.rows) if len(row.get(kind, ())) >= self.joint]
        return next((value for value in reversed(values) if value is not None), None)


class RecordingProcess:
    """Runs at most one `daq` that moves drives at a time, in the folder `root`."""

    def __init__(self, root: Path, changes: Changes) -> None:
        self._root, self._changes = root, changes
        self._process: subprocess.Popen[str] | None = None
        self.run: RunStatus | None = None
        self._last_seen = self._last_told = 0.0
        self._closed = False

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
            BadInput: a run is in progress, the rig file is invalid, or the program `daq` is missing.
        """
        arguments = ("record", *as_words(options), "--status", "--out", file.name)
        self._launch(arguments, self._rig(options), file)

    def commission(self, name: str, options: Mapping[str, str]) -> None:
        """Start `daq jog`, `home` or `axis-check` for one joint; no recording is kept.

        A jog moves only while `keep_alive` is called, and until `release` is.

        Raises:
            BadInput: as `start`, or there is no such joint.
        """
        rig, joint = self.rig_and_joint(options)
        hold = ("--hold", "--status") if name == "jog" else ()
        self._launch((name, *as_words(options), *hold), rig, None, joint, keep_alives=bool(hold))

    def rig_and_joint(self, options: Mapping[str, str]) -> tuple[Rig, int]:
        """Return the rig, and the number of the joint, that `options` mean.

        Raises:
            BadInput: the rig file is invalid, or there is no such joint.
        """
        rig, joint = self._rig(options), options["--joint"]
        if joint not in map(str, range(1, rig.dof + 1)):
            raise BadInput(f"joint: 1 to {rig.dof} expected, {joint or 'nothing'} found")
        return rig, int(joint)

    def keep_alive(self) -> None:
        """Tell a jog that its button is still held."""
        self._to_input(lambda stdin: print(".", end="", flush=True, file=stdin))

    def release(self) -> None:
        """Tell a jog that its button is not held any more: it ramps down and disables the drives."""
        self._to_input(lambda stdin: stdin.close())

    def _to_input(self, action: Callable[[IO[str]], None]) -> None:
        stdin = self._process.stdin if self._process else None
        if stdin is not None and not stdin.closed:
            # The jog may end by itself meanwhile.
            with suppress(OSError, ValueError):
                action(stdin)

    def _rig(self, options: Mapping[str, str]) -> Rig:
        return load_rig(self._root / options["--rig"]) if "--rig" in options else simulated_rig()

    def _launch(
        self,
        arguments: tuple[str, ...],
        rig: Rig,
        file: Path | None,
        joint: int = 1,
        *,
        keep_alives: bool = False,
    ) -> None:
        if self._closed:
            raise BadInput("a page that is open expected, it is being closed; start it again")
        if self.running:
            raise BadInput("no other run expected, one is in progress; stop it first")
        # A new session: Ctrl-C in the terminal must not reach the process directly, as it is stopped by `close`.
        self._process = process = subprocess.Popen(
            [*daq_command(), *arguments],
            cwd=self._root,
            stdin=subprocess.PIPE if keep_alives else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.run = run = RunStatus(("daq", *arguments), file, rig.position_units[joint - 1], joint)
        assert process.stderr is not None
        message_reader = threading.Thread(target=run.messages.extend, args=(messages(process.stderr),), daemon=True)
        message_reader.start()
        threading.Thread(target=self._read_status, args=(process, run, message_reader), daemon=True).start()
        threading.Thread(target=self._watch_browser, args=(run,), daemon=True).start()
        self._changes.mark("run", "folder")

    def stop(self) -> None:
        """Ramp down along the motion and disable the drives; called again: quick stop."""
        if self._process is not None and self.run and self.running:
            self.run.stop_count += 1
            self._process.send_signal(signal.SIGTERM)
            self._changes.mark("run")

    def close(self) -> None:
        """Bring the drives to rest before the server ends. After the timeout the closed pipe stops them."""
        self._closed = True
        self.stop()
        try:
            if self._process is not None:
                self._process.wait(_STOP_TIMEOUT)
        except subprocess.TimeoutExpired:
            self.stop()

    def _read_status(
        self,
        process: "subprocess.Popen[str]",
        run: RunStatus,
        message_reader: threading.Thread,
    ) -> None:
        with process:
            assert process.stdout is not None
            for line in process.stdout:
                self._take_line(run, line.rstrip())
            message_reader.join()  # all messages are read before the exit status is set
        run.exit_code = process.wait()
        self._changes.mark("run", "folder")

    def _watch_browser(self, run: RunStatus) -> None:
        while self.run is run and run.exit_code is None and not run.stop_count:
            if time.monotonic() - self._last_seen > _UNATTENDED_TIMEOUT:
                run.messages.append("no browser shows the page any more: stopping")
                self.stop()
            time.sleep(_BROWSER_INTERVAL)

    def _take_line(self, run: RunStatus, line: str) -> None:
        try:
            status = json.loads(line)
        except ValueError:
            status = None
        if not isinstance(status, dict):  # it is for people
            run.messages.extend([line] if line else [])
            return
        rows = status.pop("rows", [])
        run.rows.extend(rows)
        if rows and "lateness" in status:
            run.lateness.append((rows[-1]["time"], status["lateness"]))
        run.status = {**run.status, **status}
        if (now := time.monotonic()) - self._last_told > _TOLD_INTERVAL:
            self._last_told = now
            self._changes.mark("run")
