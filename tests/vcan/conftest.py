"""Fixtures of the tests on a kernel vcan0: a rig file, the programs as processes, independent CAN tools."""

import os
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import can
import pytest

from drivers import cia402
from tests import timekeeping
from tests.conftest import Finished, launcher

# Collected only by tests/vcan/run, which creates vcan0 and sets this variable.
collect_ignore_glob = [] if "VCAN_OUT" in os.environ else ["test_*.py"]

_RIG = """
name = "bench"
rate = {rate}
[bus]
interface = "socketcan"
channel = "vcan0"
sync = "{sync}"
[limits]            # a computer that stalls for seconds causes jumps of the motion, which are no fault of the drives
following_error = 100
speed = 1000
torque = 10000
host_stall = 60
silence = 60
[[drives]]
node_id = 1
[[drives]]
node_id = 2
[[drives]]
node_id = 3
"""
_IMPORT = "from tests.vcan import patience; patience."

_FIRST = 20
"""SCHED_FIFO priority; the recorder's cycle has 10."""
_START = 300.0
"""Time that a program may take to start [s]."""
_MARK = 0x7FF
"""Arbitration id that no other program uses."""

Frames = Counter[tuple[int, str]]
"""Number of occurrences of each frame (arbitration id, data in hex)."""


@dataclass
class Run:
    """A recording in real time, the frames that candump recorded, and the computer's timekeeping."""

    file: Path
    done: Finished
    bus_frames: Frames
    machine: timekeeping.Machine


class Bench:
    """A folder with a rig file for vcan0, and its processes. Each process has ended when its block ends."""

    def __init__(self, folder: Path, rate: float, sync: str = "host") -> None:
        self.folder = folder
        self.rig = folder / "vcan.toml"
        self.rig.write_text(_RIG.format(rate=rate, sync=sync))

    @contextmanager
    def simulated_rig(self, pace: str) -> Iterator[subprocess.Popen[str]]:
        """Run `daq sim`; the block begins when it is ready."""
        with _process(_daq("of_simulation()", "sim", "--until-eof", "--rig", self.rig, "--pace", pace)) as process:
            assert process.stdout is not None
            assert "simulated drives (node 1, node 2, node 3)" in process.stdout.readline()
            yield process

    @contextmanager
    def recording(self, out: Path, pace: str, *options: str) -> Iterator[subprocess.Popen[str]]:
        """Run `daq record` of fig5a."""
        with self._record(out, "--pace", pace, *options) as process:
            yield process

    def record(self, out: Path, pace: str, *options: str) -> Finished:
        """Run `daq record` to its end."""
        with self.recording(out, pace, *options) as process:
            return finished(process)

    def record_watched(self, out: Path) -> Run:
        """Record one cycle in real time."""
        with self.candump() as bus_frames, self.simulated_rig("realtime"), watched() as machine:
            done = self.record(out, "realtime", "--cycles", "1", "--json")
        assert done.code == 0, done.err
        return Run(out, done, bus_frames, machine)

    @contextmanager
    def listening(self, out: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
        """Run `daq record --listen` for fig5a; the block begins when it listens."""
        with self._record(out, "--listen", *options) as process:
            assert process.stderr is not None
            assert "sending nothing" in process.stderr.readline()
            yield process

    def _record(self, out: Path, *options: object) -> AbstractContextManager["subprocess.Popen[str]"]:
        out.unlink(missing_ok=True)
        return _process(_daq("of_recorder()", "record", "--rig", self.rig, "--traj", "fig5a", "--out", out, *options))

    @contextmanager
    def candump(self) -> Iterator[Frames]:
        """Count the frames that candump of can-utils records in the block; complete when the block has ended."""
        frames = Frames()
        log = self.folder / "candump.log"
        with log.open("w") as file, _process(["candump", "-L", "-d", "-r", str(2**23), "vcan0"], stdout=file):
            _mark(log, "00")
            yield frames
            _mark(log, "01")
        for line in log.read_text().splitlines():
            _, _, frame = line.split()
            arbitration_id, _, data = frame.partition("#")
            if int(arbitration_id, 16) != _MARK:
                frames[int(arbitration_id, 16), data.lower()] += 1


def _mark(log: Path, text: str) -> None:
    """Send a mark frame until candump has recorded it."""
    mark = f"{_MARK:03X}#{text}"
    deadline = time.monotonic() + _START
    while not log.read_text().endswith(f"{mark}\n"):
        assert time.monotonic() < deadline, "candump does not listen"
        cansend(mark)
        time.sleep(0.2)


def cansend(frame: str) -> None:
    """Send one frame with can-utils."""
    subprocess.run(["cansend", "vcan0", frame], check=True)


def _daq(patient: str, *arguments: object) -> list[str]:
    *python, program = launcher("daq")
    return [*python, f"{_IMPORT}{patient}; {program}", *map(str, arguments)]


def finished(process: "subprocess.Popen[str]") -> Finished:
    """Exit code and output of the process, after it has ended."""
    out, err = process.communicate(timeout=900)
    assert "Traceback" not in err, err
    return Finished(process.returncode, out, err)


def wait_until_moving(process: "subprocess.Popen[str]", cycles: int = 300) -> None:
    """Wait until all drives have answered `cycles` SYNCs with "operation enabled"."""
    with can.Bus(interface="socketcan", channel="vcan0", can_filters=[{"can_id": 0x180, "can_mask": 0x780}]) as bus:
        enabled = Counter[int]()
        deadline = time.monotonic() + _START
        while len(enabled) < 3 or min(enabled.values()) < cycles:
            message = bus.recv(1.0)
            if message is None:
                if process.poll() is not None or time.monotonic() > deadline:
                    process.terminate()
                    pytest.fail(f"the drives never moved: {finished(process)}")
                continue
            word = int.from_bytes(message.data[:2], "little")
            enabled[message.arbitration_id] += cia402.decode(word) is cia402.DriveState.ENABLED


@contextmanager
def _process(command: list[str], stdout: IO[str] | int = subprocess.PIPE) -> Iterator["subprocess.Popen[str]"]:
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=stdout, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


@contextmanager
def watched() -> Iterator[timekeeping.Machine]:
    """Measure how this computer keeps time for a program with real-time priority, where permitted, as the recorder
    has."""
    with ExitStack() as stack:
        # The process that measures inherits the priority.
        with suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_FIRST))
        try:
            machine = stack.enter_context(timekeeping.watched())
        finally:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        yield machine


@pytest.fixture(scope="session")
def out() -> Path:
    """Folder for the results that are used after the tests."""
    return Path(os.environ["VCAN_OUT"])
