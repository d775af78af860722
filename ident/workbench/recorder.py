"""Recording from the page: `daq` runs as a process of its own, is watched through its status lines, and is stopped by
a signal. Nothing of it is imported.
"""

import json
import shutil
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from recordings.errors import BadInput

_KEPT = 3000
"""Cycles that the live plots show at most."""
_LINES = 200
_PATIENCE = 10.0
"""How long drives may take to come to rest when the page closes [s]."""


@dataclass
class Run:
    """A recording that is going on, or the last one."""

    command: tuple[str, ...]
    out: Path
    status: dict[str, Any] = field(default_factory=dict)
    rows: deque[dict[str, Any]] = field(default_factory=lambda: deque(maxlen=_KEPT))
    """Cycles: time [s], command and position [rad], voltage [V]."""
    lateness: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=_KEPT))
    """Time [s], and the worst lateness since the last one [s]."""
    said: deque[str] = field(default_factory=lambda: deque(maxlen=_LINES))
    """What the program writes for a person."""
    stops: int = 0
    """How often it was asked to stop."""
    code: int | None = None
    """None while it runs."""

    @property
    def rig_file(self) -> bool:
        """Whether a rig file says where the drives are; without one they are simulated."""
        return "--rig" in self.command


class Recorder:
    """At most one `daq record` at a time, in the folder `root`."""

    def __init__(
        self,
        root: Path,
        told: Callable[[], None],
        changed: Callable[[], None],
        attended: Callable[[], bool] = lambda: True,
    ) -> None:
        """`told`: called with every line of its status; `changed`: when a run begins and ends; `attended`: whether
        somebody has a stop button before them.
        """
        self._root, self._told, self._changed, self._attended = root, told, changed, attended
        self._process: subprocess.Popen[str] | None = None
        self.run: Run | None = None

    @property
    def going(self) -> bool:
        """Whether drives may be moving."""
        return self._process is not None and self._process.poll() is None

    def start(self, arguments: Sequence[str], out: Path) -> None:
        """Begin `daq record` with these `arguments`, into the new file `out`.

        Raises:
            BadInput: a run is going on, or the program `daq` is missing.
        """
        if self.going:
            raise BadInput("one recording at a time expected, one is going on; stop it first")
        command = [*program(), "record", *arguments, "--status", "--out", out.name]
        self.run = run = Run(("daq", *command[-len(arguments) - 4 :]), out)
        # A session of its own: Ctrl-C in the terminal must reach it once, from us, not twice.
        self._process = process = subprocess.Popen(
            command,
            cwd=self._root,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        hearing = threading.Thread(target=_hear, args=(process, run), daemon=True)
        hearing.start()
        threading.Thread(target=self._watch, args=(process, run, hearing), daemon=True).start()
        self._changed()

    def stop(self) -> None:
        """Once: ramp down along the motion and disable; again: quick stop at once."""
        if self._process is not None and self.going and self.run:
            self.run.stops += 1
            self._process.send_signal(signal.SIGTERM)
            self._told()

    def close(self) -> None:
        """Bring the drives to rest before the page goes. If they are not by then, the closed pipe stops them."""
        if self._process is None or not self.going:
            return
        self.stop()
        try:
            self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self.stop()

    def _watch(self, process: "subprocess.Popen[str]", run: Run, hearing: threading.Thread) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            said = _parsed(line)
            if "rows" in said:
                rows = said.pop("rows")
                run.rows.extend(rows)
                if rows:
                    run.lateness.append((rows[-1]["time"], said["lateness"]))
            run.status = {**run.status, **said}
            if not run.stops and not self._attended():
                run.said.append("nobody has the page open any more: stopping")
                self.stop()
            self._told()
        code = process.wait()
        hearing.join()  # why it ended is said before that it has
        run.code = code
        self._changed()


def _hear(process: "subprocess.Popen[str]", run: Run) -> None:
    assert process.stderr is not None
    for line in process.stderr:
        run.said.append(line.rstrip())


def program() -> list[str]:
    """The start of a command line of `daq`: the one that was installed together with this program.

    Raises:
        BadInput: there is none.
    """
    beside = Path(sys.executable).with_name("daq")
    found = str(beside) if beside.exists() else shutil.which("daq")
    if found is None:
        raise BadInput("the program `daq` expected beside `ident`, none found; install delta-workbench as a whole")
    return [found]


def ask(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Let `daq` say something that takes a moment, such as a pre-flight check."""
    return subprocess.run(
        [*program(), *arguments], cwd=root, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120
    )


def _parsed(line: str) -> dict[str, Any]:
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
