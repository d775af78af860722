"""Adapters: every interface of python-can gets its arguments, and what adapters do differently changes nothing."""

import math
import time
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import can
import pytest

from drivers.canopen.bus import Link, open_bus
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.self_test import self_test
from drivers.protocol import Power, Sample, unheard
from drivers.simulated.config import SimConfig
from drivers.simulated.rig import SimulatedRig
from recordings.buses import bus_from
from recordings.config import validated
from recordings.errors import BadInput
from recordings.reader import read
from recordings.rig import CanBus, Rig, simulated_rig
from tests.conftest import Runner
from tests.drivers.canopen.slcan_adapter import SlcanAdapter
from tests.running import free_port

ADAPTERS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "pcan": ({"channel": "PCAN_USBBUS1"}, {"channel": "PCAN_USBBUS1", "bitrate": 500_000}),
    "kvaser": (
        {"channel": 0, "options": {"single_handle": True}},
        {"channel": 0, "bitrate": 500_000, "single_handle": True},
    ),
    "ixxat": ({"channel": "1"}, {"channel": 1, "bitrate": 500_000}),
    "vector": ({"channel": 0, "options": {"app_name": "daq"}}, {"channel": 0, "bitrate": 500_000, "app_name": "daq"}),
    "slcan": ({"channel": "/dev/ttyACM0@115200"}, {"channel": "/dev/ttyACM0@115200", "bitrate": 500_000}),
    "gs_usb": ({"channel": 0, "options": {"index": 0}}, {"channel": 0, "bitrate": 500_000, "index": 0}),
    "socketcan": ({"channel": "can0"}, {"channel": "can0"}),
    "virtual": ({"channel": "a"}, {"channel": "a"}),
}
"""Keys of the rig file, and arguments of `can.Bus`."""


@pytest.mark.parametrize("interface", ADAPTERS)
def test_each_interface_gets_its_arguments(interface: str, monkeypatch: pytest.MonkeyPatch) -> None:
    keys, arguments = ADAPTERS[interface]
    given: dict[str, Any] = {}

    def opened(**kwargs: Any) -> can.BusABC:
        given.update(kwargs)
        return MagicMock()

    monkeypatch.setattr(can, "Bus", opened)
    open_bus(validated({"interface": interface, "bitrate": 500_000} | keys, CanBus, "rig")).shutdown()
    assert given == {"interface": interface} | arguments


@pytest.mark.parametrize(
    ("interface", "words"),
    [("socketcn", "python-can has .*gs_usb.*socketcan"), ("pcan", "its driver"), ("slcan", "cannot be opened")],
)
def test_an_adapter_that_is_not_there_is_an_error_in_a_sentence(interface: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        open_bus(CanBus(interface=interface, channel="/nowhere/tty"))


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("gs_usb:0,index=1,bitrate=250000", {"interface": "gs_usb", "channel": 0, "bitrate": 250_000, "index": 1}),
        (
            "vector:0,app_name=daq,rx_queue_size=1024",
            {"interface": "vector", "channel": 0, "bitrate": 1_000_000, "app_name": "daq", "rx_queue_size": 1024},
        ),
        ("socketcan:can0", {"interface": "socketcan", "channel": "can0"}),
    ],
)
def test_options_of_an_interface_stand_behind_its_channel(
    text: str, arguments: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, Any] = {}
    monkeypatch.setattr(can, "Bus", lambda **kwargs: given.update(kwargs) or MagicMock())
    open_bus(bus_from(text)).shutdown()
    assert given == arguments


def test_groups_have_ports_of_their_own() -> None:
    """The one of python-can has the port of python-can; a port that is given stays."""
    groups = [f"239.74.163.{last}" for last in range(256)] + ["ff15::1"]
    ports = {bus_from(f"udp_multicast:{group}").udp_port for group in groups if ":" not in group}
    assert len(ports) == 256
    assert bus_from("udp_multicast:239.74.163.2").udp_port == 43113
    assert bus_from("udp_multicast:239.74.163.9:5000").udp_port == 5000
    with pytest.raises(BadInput, match="address of a multicast group"):
        open_bus(CanBus(interface="udp_multicast", channel="delta"))


def test_another_group_on_the_same_port_is_not_heard() -> None:
    port = free_port()
    ours, same, foreign = (open_bus(bus_from(f"udp_multicast:239.74.163.{last}:{port}")) for last in (7, 7, 8))
    try:
        for number, bus in ((0x111, foreign), (0x222, same)):
            bus.send(can.Message(arbitration_id=number, is_extended_id=False))
        heard = ours.recv(5.0)
        assert heard is not None
        assert heard.arbitration_id == 0x222
    finally:
        for bus in (ours, same, foreign):
            bus.shutdown()


class Adapter(can.BusABC):
    """Returns each sent frame, marked as sent, with the time since it was switched on."""

    def __init__(self, stamp: float) -> None:
        super().__init__("double")
        self.channel_info = "double"
        self._stamp = stamp
        self.waiting: list[can.Message] = []

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        echo = can.Message(
            arbitration_id=msg.arbitration_id, is_extended_id=False, is_rx=False, timestamp=self._stamp
        )
        self.waiting.append(echo)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return (self.waiting.pop(0) if self.waiting else None), True


@pytest.mark.parametrize("kept", [True, False])
def test_own_frames_and_foreign_clocks(kept: bool) -> None:
    stamp = time.time() if kept else 12.5
    adapter, times = Adapter(stamp), list[int]()
    link = Link(adapter)
    link.tap = lambda time_ns, message, sent: times.append(time_ns) if not sent else None
    link.send(0x80, b"")
    assert link.receive(0.0) is None
    assert link.echoes == 1
    adapter.waiting.append(can.Message(arbitration_id=0x181, is_extended_id=False, timestamp=stamp))
    before = time.time_ns()
    assert link.receive(0.0) == (0x181, b"")
    assert (times == [round(stamp * 1e9)]) if kept else (times[0] >= before)


def test_frames_keep_their_order_when_they_are_read_late() -> None:
    now = time.time()
    adapter, times = Adapter(now), list[int]()
    link = Link(adapter)
    link.tap = lambda time_ns, message, sent: times.append(time_ns)
    stamps = [now, now - 3.0, now - 0.5]  # the program stood still for three seconds before it read the second
    adapter.waiting = [can.Message(arbitration_id=0x181, is_extended_id=False, timestamp=stamp) for stamp in stamps]
    for _ in stamps:
        link.receive(0.0)
    assert times == [round(stamp * 1e9) for stamp in stamps]


def test_self_test_says_what_the_adapter_does() -> None:
    rig = simulated_rig()
    with SimulatedRig(rig, SimConfig(), open_bus(rig.can), pace="lockstep", seed=0):
        drives = CanopenDrives(rig, Link(open_bus(rig.can)), unheard)
        drives.discover()
        drives.configure()
        rows = {row.what.removeprefix("self-test: "): row for row in drives.self_test(0.2)}
        drives.close()
    assert list(rows) == ["own frames", "time stamps", "load", "lateness of SYNC", "answers"]
    assert "ms" in rows["lateness of SYNC"].found
    assert "none come back" in rows["own frames"].found
    assert f"of {round(0.2 * rig.rate)} missing: " in rows["answers"].found


def test_self_test_names_the_joint_that_does_not_answer() -> None:
    rig = simulated_rig()
    silent = Sample((0.0, math.nan, 0.0), (0.0,) * 3, (0,) * 3, (0,) * 3, (Power.OFF,) * 3, 1, None)
    rows = {row.what: row for row in self_test(rig, Link(Adapter(0.0)), lambda *given: silent, 0.05)}
    answers = rows["self-test: answers"]
    assert (answers.verdict, answers.found.partition("missing: ")[2]) == ("problem", "joint 2: 25")


def rig_over(path: str) -> str:
    options = "options = { sleep_after_open = 0.0 }"
    limits = "[limits]\nsilence = 1.0\n"
    drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
    return f'name = "bench"\nrate = 100\n{limits}[bus]\ninterface = "slcan"\nchannel = "{path}"\n{options}\n{drives}'


@pytest.mark.slow
def test_a_recording_over_slcan(daq_in_process: Runner, tmp_path: Path) -> None:
    rig = Rig(**simulated_rig().model_dump() | {"rate": 100.0, "bus": CanBus(channel="behind slcan")})
    machine = SimulatedRig(rig, SimConfig(), open_bus(rig.can), pace="lockstep", seed=0)
    with SlcanAdapter("behind slcan") as adapter, machine:
        (tmp_path / "rig.toml").write_text(rig_over(adapter.path))
        done = daq_in_process(
            "record", "--traj", "fig5a", "--cycles", 1, "--rig", "rig.toml", "--pace", "lockstep", "--json"
        )
        assert done.code == 0, done.err
    assert adapter.commands[:2] == [b"C", b"S8"]
    recording = read(tmp_path / "fig5a.mcap")
    assert recording.gaps.sum() == 0
