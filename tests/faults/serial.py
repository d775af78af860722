"""Faults of serial lines and of their drives; each drive has its own line.

Faults that stop all answers run in real time: in lockstep, simulated time would stop.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from daq.cycle.session import RunRequest
from drivers.simulated.config import SimConfig
from drivers.simulated.serial_rig import SerialRig
from recordings.config import validated
from recordings.rig import Rig
from tests.faults import feedforward
from tests.faults.campaign import Fault, Outcome, WatchedProgress, finally_powered, judge, record
from trajectories import load

RATE = 80.0
START = 3.5
"""Machine time of the fault [s], in mid-motion."""

Disturbance = Callable[[bytes, int], bytes]
"""Function of a reply and its number since the fault began; returns the received bytes."""


@dataclass(frozen=True, kw_only=True)
class SerialFault(Fault):
    """Fault that disturbs the replies of the second line or acts once on the rig."""

    disturb: Disturbance = lambda reply, number: reply
    act: Callable[[SerialRig], object] = lambda rig: None
    start: float = START
    protected: bool = True
    """Whether the drives have a watchdog."""


NO_ANSWER = "joint 2.*no answer|port simulated 2 is lost"

FAULTS: tuple[SerialFault, ...] = (
    SerialFault("serial: none", "done", 0),
    SerialFault("serial: one reply lost", "done", 0, disturb=lambda reply, k: b"" if k == 0 else reply),
    SerialFault("serial: all replies lost", NO_ANSWER, 1, disturb=lambda reply, k: b"", pace="realtime"),
    SerialFault(
        "serial: one reply garbled", "done", 0, disturb=lambda reply, k: b"\xff\x00" + reply[1:] if k == 0 else reply
    ),
    SerialFault(
        "serial: all replies garbled",
        NO_ANSWER,
        1,
        disturb=lambda reply, k: bytes(b ^ 0x55 for b in reply),
        pace="realtime",
    ),
    SerialFault("serial: one reply cut", "done", 0, disturb=lambda reply, k: reply[:1] if k == 0 else reply),
    SerialFault(
        "serial: noise before replies",
        "done|joint 2.*no answer",
        0,
        disturb=lambda reply, k: b"\x00" * 3 + reply if k == 5 else reply,
    ),
    SerialFault(
        "serial: error code in place of a reply", "done", 0, disturb=lambda reply, k: b"e 33\r" if k == 0 else reply
    ),
    SerialFault("serial: babble without end", NO_ANSWER, 1, disturb=lambda reply, k: b"x" * 200, pace="realtime"),
    SerialFault("serial: line unplugged", NO_ANSWER, 1, act=lambda rig: rig.unplug("simulated 2"), pace="realtime"),
    SerialFault("serial: drive fault in mid-motion", "joint 2.*fault", 1, act=lambda rig: rig.drives[1].fail(1)),
    SerialFault(
        "serial: drive fault before power", "joint 1.*fault|done", 0, act=lambda rig: rig.drives[0].fail(1), start=0.0
    ),
    SerialFault("serial: no watchdog", r"joint 1.*watchdog missing.*accept_missing", 2, protected=False),
    SerialFault(
        "serial: no watchdog, accepted",
        "done; watchdog missing.*the rig file accepts it",
        0,
        protected=False,
        drive={"accept_missing": ["watchdog"]},
    ),
)


WITH_FEEDFORWARD: tuple[SerialFault, ...] = (
    *(replace(fault, name=f"feed-forward, {fault.name}", feedforward=feedforward.model()) for fault in FAULTS),
    *(
        SerialFault(f"serial: {name}", feedforward.WRONG, 1, feedforward=feedforward.model(*factors))
        for name, factors in (
            ("model with gravity reversed", (1.0, -1.0)),
            ("model three times too strong", (3.0, 3.0)),
        )
    ),
)
"""Faults of lines and drives again, with a good model; and wrong models."""


def run(fault: SerialFault) -> Outcome:
    """Record one cycle of fig5b with the fault in mid-motion."""
    rig = _rig(fault) if fault.feedforward is None else _rig(fault).with_torque_offset()
    trajectory = load("fig5b", rig, cycles=1)
    feed = None if fault.feedforward is None else fault.feedforward(rig, trajectory)
    with tempfile.TemporaryDirectory() as folder:
        request = RunRequest(rig, trajectory, Path(folder) / "fault.mcap", fault.pace, 0, feedforward=feed)
        machine = SerialRig(rig, SimConfig(), pace=fault.pace, seed=0)
        has_begun = _sabotage(machine, fault)
        progress = WatchedProgress()
        with machine:
            code, reason = record(request, fault, progress)
            powered = finally_powered(machine.drives)
        start = round(fault.start * RATE)
        begun = fault.pace == "lockstep" or has_begun()
        return judge(fault, code, reason, powered, request.out, progress, start, RATE, None, None, begun)


def _rig(fault: SerialFault) -> Rig:
    registers = {"torque_offset": "r0xd5", "watchdog": "r0xf0" if fault.protected else ""}
    bus = {
        "transport": "serial",
        "ports": [f"simulated {k}" for k in (1, 2, 3)],
        "baud": 460800,
        "registers": registers,
    }
    drives = [{"node_id": k, **fault.drive} for k in (1, 2, 3)]
    # Wide limits: at this rate a lost target costs 12 ms of motion, which must not hide the fault under test.
    limits = {"torque": 500.0, "following_error": 0.3, "silence": 0.1, "host_stall": 0.5}
    content = {"name": "serial faults", "rate": RATE, "bus": bus, "limits": limits, "drives": drives}
    return validated(content, Rig, "campaign")


def _sabotage(machine: SerialRig, fault: SerialFault) -> Callable[[], bool]:
    """Let the fault come; returns whether it has."""
    count = 0
    acted = False

    def disturb(port: str, reply: bytes) -> bytes:
        nonlocal count, acted
        if machine.machine.time < fault.start:
            return reply
        if not acted:
            acted = True
            fault.act(machine)
        if port != "simulated 2":
            return reply
        count += 1
        return fault.disturb(reply, count - 1)

    machine.disturb = disturb
    return lambda: acted
