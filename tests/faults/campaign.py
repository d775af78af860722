"""Run one fault during a recording in lockstep and judge its outcome."""

import itertools
import json
import math
import os
import re
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import can
import numpy as np

from daq.cycle.progress import CycleProgress
from daq.cycle.session import RunRequest, Session
from daq.feedforward.source import TorqueSource
from drivers.simulated.config import SimConfig
from drivers.simulated.mark import EDS
from drivers.simulated.rig import SimulatedRig
from drivers.simulated.service import SimulatedDrive
from recordings.errors import BadInput, RunFailed
from recordings.reader import read
from recordings.rig import Rig, simulated_rig
from tests.faults.bridge import Bridge, Saboteur, unchanged
from tests.faults.patience import PatientClock
from tests.faults.saboteurs import START
from trajectories import Trajectory, load

RATE = 250.0
STOP_CYCLES = 3
"""Cycles within which no drive is commanded to follow its target any more."""
_numbers = itertools.count()


@dataclass(frozen=True)
class Fault:
    """A fault and its required outcome."""

    name: str
    reason: str
    """Regular expression of the reason that the run reports; "done" if the run must tolerate the fault."""
    code: int
    """Required exit code."""
    cable: Callable[[], Saboteur] = lambda: unchanged
    rig: Callable[["SabotagedRig", int], None] = lambda rig, syncs: None
    """Called in the rig's thread before each SYNC, with the number of earlier SYNCs."""
    host: Callable[[Session], None] = lambda session: None
    """Called before the run."""
    enable: float = 3.0
    """enable_timeout of the rig file [s]."""
    drive: Mapping[str, Any] = field(default_factory=dict)
    """Keys of every drive in the rig file that differ from the default."""
    habits: Mapping[str, Any] = field(default_factory=dict)
    """Habits of every simulated drive."""
    before: Callable[["SabotagedRig"], object] = lambda rig: None
    """Called before the recorder starts."""
    events: Sequence[Mapping[str, Any]] = ()
    """[[events]] of the sim file."""
    eds: Callable[[str], str] | None = None
    """Changes the dictionary (the text of its EDS) of every simulated drive."""
    pace: Literal["lockstep", "realtime"] = "lockstep"
    limit: float = 1500.0
    """Longest time from the fault until the drives are disabled [ms]."""
    feedforward: Callable[[Rig, Trajectory], TorqueSource] | None = None
    """Torque that is fed forward; None: none."""
    park: tuple[float, float, float] = (0.0, 0.0, -0.75)
    """Platform position at power-on [m]."""
    servo: Mapping[str, float] = field(default_factory=dict)
    """Keys of [servo] in the sim file that differ from the default."""
    error_limit: float = math.inf
    """Largest following error of the machine until the drives are disabled [rad]."""


@dataclass(frozen=True)
class Outcome:
    """Outcome of a fault. Times are in ms after the fault; None if no reaction was needed."""

    fault: str
    detected: float | None
    disabled: float | None
    samples_lost: int
    rows_lost: int
    """Number of SYNCs that are missing in the file."""
    code: int
    reason: str
    safe: bool
    """Whether the drives ended without power and the file is complete, independent of the machine's load."""
    passed: bool
    """Whether the outcome is safe and as required; in real time this needs a machine that keeps time."""
    begun: bool = True
    """False: in real time, a busy machine ended the run before the fault, which was not tried."""
    following_error: float | None = None
    """Largest following error of the machine with power [rad]; None: unknown."""


class SabotagedRig(SimulatedRig):
    """Simulated rig that is sabotaged at SYNCs and stores the time at which its drives lost power."""

    act: Callable[["SabotagedRig", int], None]
    """Called before each SYNC with the number of earlier SYNCs."""
    synchronised = 0
    """Number of SYNCs that have been answered."""
    sent = 0
    """Number of frames sent."""
    fault_time = 0.0
    disabled_time: float | None = None
    worst_error = 0.0
    """Largest following error with power [rad]."""
    _was_powered = False

    def _synchronise(self) -> None:
        if self.synchronised < START:
            self.fault_time = self.machine.time
        self.act(self, self.synchronised)
        super()._synchronise()
        self.synchronised += 1

    def _on_any_frame(self, stamp: int, message: can.Message, sent: bool) -> None:
        super()._on_any_frame(stamp, message, sent)
        self.sent += sent

    def _handle(self, arbitration_id: int, data: bytes) -> None:
        super()._handle(arbitration_id, data)
        self._observe()

    def _update(self) -> None:
        super()._update()
        self._observe()

    def _observe(self) -> None:
        powered = any(drive.powered for drive in self.drives)
        # A drive has power from the machine's next step on.
        if all(self.machine.enabled):
            self.worst_error = max(self.worst_error, *map(abs, self.machine.following_error()))
        if self._was_powered and not powered:
            self.disabled_time = self.machine.time
        self._was_powered = powered


class WatchedProgress(CycleProgress):
    """Stores the cycle in which the run began to stop."""

    ended_at: int | None = None
    at_once = False
    """Whether the drives were then stopped at once, not along the path."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "phase" and value in ("stop", "disable") and self.ended_at is None:
            super().__setattr__("ended_at", self.cycles)
            super().__setattr__("at_once", value == "disable")
        super().__setattr__(name, value)


def run(fault: Fault) -> Outcome:
    """Record one cycle of fig5b with the fault in mid-motion."""
    number = next(_numbers)
    master, far = f"master-{os.getpid()}-{number}", f"rig-{os.getpid()}-{number}"
    rig = _rig(master, fault)
    with tempfile.TemporaryDirectory() as folder:
        trajectory = load("fig5b", rig, cycles=1)
        feed = None if fault.feedforward is None else fault.feedforward(rig, trajectory)
        request = RunRequest(rig, trajectory, Path(folder) / "fault.mcap", fault.pace, 0, feedforward=feed)
        bus = can.Bus(interface="virtual", channel=far)
        machine = SabotagedRig(rig, _config(fault, Path(folder)), bus, pace=fault.pace, seed=0)
        machine.act = fault.rig
        fault.before(machine)
        with Bridge(master, far, fault.cable()) as bridge, machine:
            progress = WatchedProgress()
            code, reason = record(request, fault, progress, partial(_is_settled, bridge, machine))
            powered = finally_powered(machine.drives)
        disabled = None
        if code and machine.disabled_time is not None:
            disabled = max(0.0, (machine.disabled_time - machine.fault_time) * 1e3)
        begun = fault.pace == "lockstep" or (progress.ended_at or 0) >= START
        outcome = judge(
            fault, code, reason, powered, request.out, progress, START, RATE, bridge.syncs, disabled, begun
        )
        held = machine.worst_error <= fault.error_limit
        if progress.ended_at is not None and progress.at_once:
            # The next cycle, whose stop command follows ended_at SYNCs, is the first one after the detection.
            held = held and bridge.enabled_until + 1 < progress.ended_at + STOP_CYCLES
        return replace(outcome, passed=outcome.passed and held, following_error=machine.worst_error)


def _is_settled(bridge: Bridge, machine: SabotagedRig, syncs: int) -> bool:
    """Whether the rig has heard the master's first `syncs` SYNCs, and the master all that the rig has answered."""
    if machine.error is not None:
        raise machine.error
    heard = bridge.syncs >= syncs and machine.synchronised >= bridge.delivered_syncs
    return heard and bridge.answers >= machine.sent


def _config(fault: Fault, folder: Path) -> SimConfig:
    drive: dict[str, Any] = {"habits": dict(fault.habits)}
    if fault.eds is not None:
        drive["eds"] = str(folder / "drive.eds")
        (folder / "drive.eds").write_text(fault.eds(EDS.read_text()))
    return SimConfig.model_validate_json(
        json.dumps({"drives": [drive], "park": fault.park, "servo": dict(fault.servo), "events": [*fault.events]})
    )


def _rig(channel: str, fault: Fault) -> Rig:
    rig = simulated_rig().at_rate(RATE)
    drives = [drive.model_dump(mode="json") | dict(fault.drive) for drive in rig.drives]
    rig = Rig.model_validate_json(json.dumps(rig.model_dump(mode="json") | {"drives": drives}))
    changed: dict[str, Any] = {"bus": rig.bus.model_copy(update={"channel": channel}), "enable_timeout": fault.enable}
    if fault.pace == "realtime":
        # A busy computer, which sends targets late, must not cause a fault of its own.
        wide = {"host_stall": 10.0, "torque": 1e3, "following_error": 10.0, "speed": 1e3}
        changed["limits"] = rig.limits.model_copy(update=wide)
    rig = rig.model_copy(update=changed)
    return rig if fault.feedforward is None else rig.with_torque_offset()


def finally_powered(drives: Sequence[SimulatedDrive], patience: float = 10.0) -> list[bool]:
    """Whether each drive is still powered after its watchdog and the last SYNC had time to act (`patience` [s])."""
    deadline = time.monotonic() + patience
    while any(drive.powered for drive in drives) and time.monotonic() < deadline:
        time.sleep(0.01)
    return [drive.powered for drive in drives]


def record(
    request: RunRequest,
    fault: Fault,
    progress: "WatchedProgress",
    settled: Callable[[int], bool] | None = None,
) -> tuple[int, str]:
    """Exit code and reason of one run with its warnings; `settled`: see PatientClock, None: lockstep's own
    patience."""
    warnings: list[str] = []
    session = Session(request, lambda level, _, text: warnings.append(text) if level == "warning" else None)
    session.progress = progress
    if request.pace == "lockstep" and settled is not None:
        session._clock = PatientClock(request.rig.rate, settled)
    fault.host(session)
    try:
        session.run(lambda progress: nullcontext())
    except BadInput as error:
        return 2, str(error)
    except RunFailed as error:
        return 1, "; ".join([str(error), *warnings])
    return 0, "; ".join(["done", *warnings])


def judge(
    fault: Fault,
    code: int,
    reason: str,
    powered: list[bool],
    path: Path,
    progress: "WatchedProgress",
    start: int,
    rate: float,
    syncs: int | None,
    disabled: float | None,
    begun: bool,
) -> Outcome:
    """Outcome of a run whose fault began at cycle `start`.

    syncs: expected number of SYNCs in the file; disabled: time at which the drives lost power [ms after the fault].
    None: unknown. begun: see `Outcome`.
    """
    detected = None
    if code and progress.ended_at is not None:
        detected = max(0.0, (progress.ended_at - start) / rate * 1e3)
    lost = rows_lost = 0
    if path.exists() and progress.cycles:
        recording = read(path)
        lost = int(np.isnan(recording.position).sum())
        rows_lost = (progress.cycles if syncs is None else syncs) - len(recording.time)
    safe = not any(powered) and rows_lost <= 0
    passed = (
        begun
        and safe
        and code == fault.code
        and re.search(fault.reason, reason) is not None
        and (disabled is None or disabled <= fault.limit)
    )
    return Outcome(fault.name, detected, disabled, lost, max(rows_lost, 0), code, reason, safe, passed, begun)
