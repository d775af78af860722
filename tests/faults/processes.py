"""Faults of programs: recorder and simulated rig run as separate processes in real time."""

import random
import re
import resource
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.rig import load_rig
from tests.conftest import launcher
from tests.daq.feedforward.given import write_nominal_torque
from tests.faults.campaign import Outcome
from tests.patience import patient
from tests.running import free_port, wait_until_moving
from trajectories import load

_RIG = """
name = "fault campaign"
rate = {rate}
[bus]
interface = "udp_multicast"
channel = "239.74.163.2"
port = {port}
[limits]
silence = {silence}
host_stall = {host_stall}
torque = 1000.0
following_error = 10.0
speed = 1000.0
[[drives]]
node_id = 1
[[drives]]
node_id = 2
[[drives]]
node_id = 3
"""

_RATE = 50.0
"""Sampling rate [Hz]: low enough for a busy machine; the faults do not depend on it."""
_STRICT = {"silence": 0.2, "host_stall": 0.3}
_PATIENT = {"silence": 5.0, "host_stall": 5.0}
"""Limits [s] for faults in which a stall must not matter; nor do late targets exceed another limit."""
_TRAJECTORY, _CYCLES = "fig5b", 10


@dataclass(frozen=True)
class ProcessFault:
    """A fault and its required outcome."""

    name: str
    reason: str
    code: int
    strike: Callable[["Programs"], object]
    """Called in mid-motion."""
    drives_alive: bool = True
    may_lose: float = 0.0
    """Longest time before the fault that may be missing in the file [s]."""
    feedforward: bool = False
    """Whether the torque of the rig's nominal masses is fed forward."""
    largest_file: int | None = None
    """Largest size of the recording [bytes], for a disk that is full."""
    limits: Mapping[str, float] = field(default_factory=lambda: _PATIENT)


class Programs:
    """The simulated rig and the recorder, running in `folder`."""

    def __init__(self, folder: Path, limits: Mapping[str, float]) -> None:
        self.folder = folder
        (folder / "rig.toml").write_text(_RIG.format(rate=_RATE, port=free_port(), **limits))
        self.rig = self._start("sim", "--rig", "rig.toml", "--until-eof")
        assert self.rig.stdout is not None
        assert "simulated drives" in self.rig.stdout.readline()
        self.recorder: subprocess.Popen[str] | None = None
        self.struck = 0.0
        """Host time of the fault [s]."""

    def _start(self, *arguments: str, limit: int | None = None) -> subprocess.Popen[str]:
        def set_limit() -> None:
            if limit is not None:
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

        return subprocess.Popen(
            [*launcher("daq"), *arguments],
            cwd=self.folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=set_limit,
        )

    def record(self, limit: int | None = None, *, feedforward: bool = False) -> subprocess.Popen[str]:
        """Start the recorder with status output; `limit`: largest size of its file [bytes]."""
        motion = ["--traj", _TRAJECTORY, "--cycles", str(_CYCLES)]
        if feedforward:
            rig = load_rig(self.folder / "rig.toml")
            write_nominal_torque(self.folder / "torque.csv", load(_TRAJECTORY, rig, _CYCLES), rig)
            motion += ["--feedforward", "torque.csv"]
        self.recorder = self._start(
            "record", *motion, "--rig", "rig.toml", "--out", "run.mcap", "--status", limit=limit
        )
        return self.recorder

    def drives_are_disabled(self, patience: float = 30.0) -> bool:
        """Whether a new master reads that all drives are disabled; `patience` for their watchdogs [s]."""
        deadline = time.monotonic() + patience
        while not self._all_disabled():
            if time.monotonic() > deadline:
                return False
        return True

    def _all_disabled(self) -> bool:
        done = subprocess.run(
            [*launcher("daq"), "check", "--rig", "rig.toml", "--json"],
            cwd=self.folder,
            capture_output=True,
            text=True,
        )
        states = re.findall(r'"what": "state",\s*"expected": "[^"]*",\s*"found": "([^",]*)', done.stdout)
        return len(states) == 3 and all(state in ("switch on disabled", "fault") for state in states)

    def end(self) -> None:
        """Terminate the running processes."""
        for process in (self.recorder, self.rig):
            if process is None:
                continue
            if process.poll() is None:
                process.terminate()
            process.communicate(timeout=patient(120))


def _signals(number: int, times: int = 1, pause: float = 0.1) -> Callable[[Programs], None]:
    def strike(programs: Programs) -> None:
        assert programs.recorder is not None
        time.sleep(random.uniform(0, 1.0))
        programs.struck = time.time()
        for _ in range(times):
            programs.recorder.send_signal(number)
            time.sleep(pause)

    return strike


def _pause(process: "subprocess.Popen[str] | None", duration: float) -> None:
    assert process is not None
    process.send_signal(signal.SIGSTOP)
    time.sleep(duration)
    process.send_signal(signal.SIGCONT)


FAULTS: tuple[ProcessFault, ...] = (
    ProcessFault("SIGINT", "SIGINT", 1, _signals(signal.SIGINT)),
    ProcessFault("SIGINT twice", "SIGINT.*twice", 1, _signals(signal.SIGINT, times=2)),
    ProcessFault("SIGINT twenty times", "SIGINT", 1, _signals(signal.SIGINT, times=20, pause=0.004)),
    ProcessFault("SIGTERM", "SIGTERM", 1, _signals(signal.SIGTERM)),
    ProcessFault("SIGHUP", "SIGHUP", 1, _signals(signal.SIGHUP)),
    ProcessFault("SIGKILL of the recorder", "", -9, _signals(signal.SIGKILL), may_lose=0.25),
    ProcessFault(
        "SIGKILL of the recorder at full torque offset",
        "",
        -9,
        _signals(signal.SIGKILL),
        may_lose=0.25,
        feedforward=True,
    ),
    ProcessFault(
        "SIGKILL of the simulated rig",
        "no answer",
        1,
        lambda programs: programs.rig.kill(),
        drives_alive=False,
        limits=_STRICT,
    ),
    ProcessFault(
        "recorder stopped for 1 s (SIGSTOP)",
        "master heartbeat lost|host came",
        1,
        lambda programs: _pause(programs.recorder, 1.0),
        limits=_STRICT,
    ),
    ProcessFault(
        "disk full in mid-motion", "run.mcap", 2, lambda programs: None, may_lose=60.0, largest_file=300_000
    ),
    ProcessFault(
        "drives stopped for 0.45 s (SIGSTOP)",
        "no answer|heartbeat lost",
        1,
        lambda programs: _pause(programs.rig, 0.45),
        limits=_STRICT,
    ),
)


def run(fault: ProcessFault) -> Outcome:
    """Record with the fault in mid-motion, then check the drives and the file."""
    with tempfile.TemporaryDirectory() as name:
        programs = Programs(Path(name), fault.limits)
        try:
            recorder = programs.record(fault.largest_file, feedforward=fault.feedforward)
            begun = fault.largest_file is not None or wait_until_moving(recorder, cycles=50)
            programs.struck = time.time()
            fault.strike(programs)
            _, err = recorder.communicate(timeout=patient(120))
            disabled = programs.drives_are_disabled() if fault.drives_alive else True
            if not begun and not (Path(name) / "run.mcap").exists():  # a busy machine ended the run before its file
                return Outcome(fault.name, None, None, 0, 0, recorder.returncode, err, disabled, False, False)
            outcome = _outcome(fault, recorder.returncode, err, disabled, programs.struck, Path(name))
            return replace(outcome, passed=outcome.passed and begun, begun=begun)
        finally:
            programs.end()


def _outcome(fault: ProcessFault, code: int, err: str, disabled: bool, struck: float, folder: Path) -> Outcome:
    *_, reason = "", *err.strip().splitlines()
    missing, kept_until, safe = 0, 0.0, disabled
    try:
        missing = int(np.isnan(read(folder / "run.mcap").position).sum())
        kept_until = read_can(folder / "run.mcap").log[-1] / 1e9
    except BadInput as error:
        reason = f"{reason} [{error}]"
        safe = False
    lost = max(0.0, struck - kept_until)
    # 0.05 s: frames in transit between the programs.
    kept = lost <= fault.may_lose + 0.05
    passed = safe and bool(kept) and code == fault.code and re.search(fault.reason, reason) is not None
    return Outcome(fault.name, None, None, missing, round(lost * _RATE), code, reason, safe, passed)
