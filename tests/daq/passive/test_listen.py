"""`daq record --listen`: records all frames, sends none, and ends as specified."""

import threading
import time
from collections.abc import Callable
from pathlib import Path

import can
import numpy as np
import pytest

from daq.commands.record import command
from daq.cycle.stopping import StopRequest
from daq.passive import listen
from daq.passive.listen import Listener
from recordings.errors import BadInput, RunFailed
from recordings.reader import read, read_can
from recordings.rig import Rig, simulated_rig
from tests.running import invoke, printed

RIG = simulated_rig()
BUS = '[bus]\ninterface = "{}"\nchannel = "x"\n'


def send(bus: can.BusABC, arbitration_id: int, data: bytes, extended: bool = False) -> None:
    bus.send(can.Message(arbitration_id=arbitration_id, data=data, is_extended_id=extended))


def master(bus: can.BusABC, cycles: int) -> None:
    """Send SYNCs, and the answers of three enabled drives at constant speed."""
    for k in range(cycles):
        for node in (1, 2, 3):
            send(bus, 0x200 + node, b"\x0f\x00" + (100 * k).to_bytes(4, "little"))
        send(bus, 0x80, b"")
        for node in (1, 2, 3):
            send(bus, 0x180 + node, b"\x37\x12" + (100 * k).to_bytes(4, "little") + b"\x64\x00")
        time.sleep(1 / RIG.rate)
    send(bus, 0x82, bytes.fromhex("1032000000000000"))


def listened(
    tmp_path: Path, channel: str, transmit: Callable[[can.BusABC], None], duration: float | None = None
) -> tuple[Listener, str, list[can.Message]]:
    """Listen while `transmit` sends in a thread, for `duration` [s] or until it ends; a third bus gets all frames."""
    buses = [can.Bus(interface="virtual", channel=channel) for _ in range(3)]
    stop = StopRequest()

    def send_frames() -> None:
        transmit(buses[0])
        if duration is None:
            # Wait until the listener has all frames of the third bus.
            while listener.traffic.frames < buses[2].queue.qsize():
                time.sleep(0.01)
            stop.ask("enough")

    listener = Listener(buses[1], RIG, tmp_path / "r.mcap")
    thread = threading.Thread(target=send_frames)
    thread.start()
    reason = listener.listen(stop, duration)
    thread.join()
    received = []
    while (message := buses[2].recv(0)) is not None:
        received.append(message)
    for bus in buses:
        bus.shutdown()
    return listener, reason, received


def test_every_frame_is_recorded_none_is_sent_and_samples_are_made_of_them(tmp_path: Path) -> None:
    listener, reason, received = listened(tmp_path, "all", lambda bus: master(bus, 50))
    assert reason == "enough"
    path = tmp_path / "r.mcap"
    frames = read_can(path)
    assert frames.id.tolist() == [message.arbitration_id for message in received]
    assert len(frames.id) == 50 * 7 + 1 == listener.traffic.frames
    assert listener.traffic.syncs == 50
    assert not frames.sent.any()
    stamps = [round(message.timestamp * 1e9) for message in received]
    np.testing.assert_allclose(frames.log, stamps, atol=2_000_000_000)
    assert (np.diff(frames.log) >= 0).all()

    with pytest.raises(BadInput, match="holds no samples"):
        read(path)
    reconstructed = listen.complete(path, RIG, None, {"exit_status": "0", "reason": reason})
    recording = read(path)
    assert len(recording.time) == 50 + reconstructed.missing
    known = np.flatnonzero(np.isfinite(recording.position[:, 0]))
    assert len(known) == 50
    counts = (recording.position[known] - recording.position[0]) * RIG.drives[0].counts_per_radian
    np.testing.assert_allclose(counts, np.tile(100.0 * np.arange(50)[:, None], 3), atol=1e-6)
    np.testing.assert_array_equal(recording.command, recording.position)
    np.testing.assert_allclose(recording.voltage[known], 0.05)
    assert (recording.repeat[known] == 0).all()
    run = recording.run
    assert (run.trajectory, run.exit_status, run.reason) == ("listened", 0, "enough")
    assert run.rate == reconstructed.rate
    assert [(event.level, event.source) for event in recording.events] == [("error", "joint 2")]
    assert "0x3210" in recording.events[0].message
    assert len(read_can(path).id) == 351


def test_listening_ends_after_the_duration(tmp_path: Path) -> None:
    _, reason, _ = listened(tmp_path, "duration", lambda bus: None, 0.2)
    assert reason == "the time to listen was over"


def test_listening_ends_when_the_syncs_have_ceased(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 0.2)
    _, reason, _ = listened(tmp_path, "silence", lambda bus: send(bus, 0x80, b""), 60.0)
    assert reason == "no SYNC for 0.2 s"


def test_stall_of_the_listener_is_no_silence_of_the_bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 0.3)
    with (
        can.Bus(interface="virtual", channel="stalled") as sender,
        can.Bus(interface="virtual", channel="stalled") as receiver,
    ):
        listener = Listener(receiver, RIG, tmp_path / "r.mcap")
        send(sender, 0x80, b"")

        def stall(traffic: listen.BusTraffic) -> None:
            if traffic.frames == 1:
                send(sender, 0x701, b"\x05")
                send(sender, 0x80, b"")
                time.sleep(0.4)

        assert listener.listen(StopRequest(), None, stall) == "no SYNC for 0.3 s"
        assert listener.traffic.syncs == 2


def test_recording_without_sync_keeps_its_frames_and_has_no_samples(tmp_path: Path) -> None:
    listened(tmp_path, "none", lambda bus: send(bus, 0x181, bytes(8)))
    with pytest.raises(RunFailed, match="no SYNC was heard"):
        listen.complete(tmp_path / "r.mcap", RIG, None, {})
    assert len(read_can(tmp_path / "r.mcap").id) == 1


SERIAL = '[bus]\ntransport = "serial"\nports = ["/dev/null"]\n'
BAD: dict[str, tuple[str | None, list[str], str]] = {
    "no rig": (None, ["--listen"], "--listen needs --rig"),
    "dry run": (
        BUS.format("socketcan"),
        ["--listen", "--dry-run"],
        "either --listen or --dry-run expected",
    ),
    "the virtual bus": (BUS.format("virtual"), ["--listen"], "ends at this program"),
    "serial": (SERIAL, ["--listen"], "a CAN bus expected"),
    "no such interface": (BUS.format("socketcan"), ["--listen"], "cannot be opened"),
    "unknown motion": (BUS.format("socketcan"), ["--listen", "--traj", "fig5z"], "unknown trajectory"),
    "duration of a motion": (None, ["--traj", "fig5a", "--duration", "3"], "how long to --listen"),
    "duration that is no number": (None, ["--listen", "--duration", "nan"], "a finite number expected, nan found"),
}


@pytest.fixture
def rig_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], str]:
    """Write a rig file with a section [bus] into the working folder."""
    monkeypatch.chdir(tmp_path)

    def write(bus: str) -> str:
        drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
        Path("rig.toml").write_text(f'name = "bench"\n{bus}{drives}')
        return "rig.toml"

    return write


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_rejected(name: str, rig_file: Callable[[str], str]) -> None:
    bus, options, expected = BAD[name]
    with pytest.raises(BadInput) as failure:
        printed(command, *options, *(("--rig", rig_file(bus)) if bus else ()))
    assert expected in str(failure.value)
    assert not Path("listened.mcap").exists()


def test_command_prints_a_summary(rig_file: Callable[[str], str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 2.0)
    listening = threading.Event()

    def opened(settings: object) -> can.BusABC:
        bus = can.Bus(interface="virtual", channel="cli")
        listening.set()
        return bus

    monkeypatch.setattr(listen, "open_bus", opened)

    def send_frames() -> None:
        with can.Bus(interface="virtual", channel="cli") as bus:
            assert listening.wait(60)
            master(bus, 30)

    thread = threading.Thread(target=send_frames)
    thread.start()
    result = invoke(command, "--listen", "--rig", rig_file(BUS.format("udp_multicast")))
    thread.join()
    assert "sending nothing" in result.stderr
    assert "syncs: 30" in result.stdout
    assert "recorded listened.mcap (listened)" in result.stdout
    assert isinstance(read(Path("listened.mcap")).rig, Rig)
