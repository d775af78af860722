"""The simulated rig on pseudo-terminals."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from drivers.protocol import Amplifiers, Goal
from drivers.serial.port import simulated
from drivers.simulated.config import SimConfig
from drivers.simulated.serial_rig import SerialRig
from drivers.transports import serial as transport
from recordings.buses import SerialRegisters
from recordings.errors import BadInput
from recordings.recording import Pace
from recordings.rig import Rig
from tests.drivers.transports.test_serial import rig
from tests.failures import assert_safe
from tests.patience import patient

pytestmark = pytest.mark.timeout(patient(60))  # a reply that does not come is waited for without end


@contextmanager
def served(described: Rig, pace: Pace = "lockstep") -> Iterator[SerialRig]:
    with SerialRig(described, SimConfig(), pace=pace, seed=0) as machine:
        yield machine
    assert machine.error is None


def say(port: str, *pieces: bytes, ends: int = 1) -> bytes:
    """Send pieces of commands; returns the reply up to `ends` end characters."""
    device = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        for piece in pieces:
            os.write(device, piece)
        reply = b""
        while reply.count(b"\r") < ends:
            reply += os.read(device, 100)
        return reply
    finally:
        os.close(device)


def test_ports_exist_while_they_are_served_and_replace_dangling_links_but_no_other_file(tmp_path: Path) -> None:
    with served(rig()):
        assert say(simulated["simulated"], b"2 g r0xa4\r") == b"v 0\r"
    assert not simulated
    link, precious = tmp_path / "line", tmp_path / "precious"
    link.symlink_to(tmp_path / "gone")
    with served(rig(str(link))):
        assert say(str(link), b"2 g r0xa4\r") == b"v 0\r"
    assert not link.is_symlink()
    precious.write_text("data")
    with pytest.raises(BadInput, match=r"precious cannot be made: File exists"):
        SerialRig(rig(str(precious)), SimConfig(), pace="lockstep", seed=0)
    assert precious.read_text() == "data"


def test_echo() -> None:
    with served(rig(echo=True)):
        assert say(simulated["simulated"], b"2 g r0xa4\r", ends=2) == b"2 g r0xa4\rv 0\r"
        drives = transport.connect(rig(echo=True), lambda *line: None, lambda *frame: None, lambda: 0)
        assert drives.discover()[1].lockstep
        drives.close()


def test_lockstep_time_advances_only_with_the_latch() -> None:
    with served(rig()) as machine:
        port = simulated["simulated"]
        first = say(port, b"1 g r0x15\r")
        assert say(port, b"1 g r0x15\r") == first  # the same instant, hence the same noise
        assert machine.machine.time == 0.0
        assert say(port, b"2 latch\r") == b"ok\r"
        say(port, b"3 g r0xa4\r")  # the period is over when it replies
        assert machine.machine.time == pytest.approx(1 / 20)


def test_real_time_includes_the_transmission_time_and_knows_no_latch() -> None:
    command, reply = b"1 g r0xa4\r", b"v 0\r"
    with served(rig(baud=1200), "realtime"):
        begin = time.perf_counter()
        assert say(simulated["simulated"], command) == reply
        assert time.perf_counter() - begin >= (len(command) + len(reply)) * 10 / 1200
        assert say(simulated["simulated"], b"2 latch\r") == b"e 3\r"


@contextmanager
def enabled(described: Rig, pace: Pace = "lockstep") -> Iterator[tuple[SerialRig, Amplifiers]]:
    """Enabled drives on their lines."""
    with served(described, pace) as machine:
        clock = (lambda: 0) if pace == "lockstep" else None
        drives = transport.connect(described, lambda *line: None, lambda *frame: None, clock)
        drives.discover()
        drives.configure()
        drives.exchange(None, 5.0)
        drives.goal = Goal.ENABLED
        while not all(drive.powered for drive in machine.drives):
            drives.exchange(None, 5.0)
        yield machine, drives
        if pace == "lockstep":
            drives.close()


@pytest.mark.realtime
@pytest.mark.parametrize("register", ["r0xf0", ""])
def test_only_a_watchdog_switches_power_off_when_the_host_is_lost(register: str) -> None:
    described = rig(registers=SerialRegisters(watchdog=register), reply_timeout=1.0)
    with enabled(described, "realtime") as (machine, _):
        # As after SIGKILL: no more commands.
        deadline = time.perf_counter() + (20.0 if register else 1.0)
        while any(drive.powered for drive in machine.drives) and time.perf_counter() < deadline:
            time.sleep(0.02)
        assert_safe(not register or not any(drive.powered for drive in machine.drives), "the watchdog does not act")
        assert register or any(drive.powered for drive in machine.drives)
