"""`daq record --listen`: records all frames, sends none, and ends as specified."""

import re
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
from daq.passive.reconstruct import Reconstructed
from recordings.errors import BadInput, RunFailed
from recordings.reader import read, read_can
from recordings.rig import simulated_rig
from tests.patience import patient
from tests.running import DRIVES, invoke

RIG = simulated_rig()


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


def listened(tmp_path: Path, channel: str, transmit: Callable[[can.BusABC], object], duration: float) -> str:
    """Why the listener ended that had `duration` [s], and heard what `transmit` sends."""
    with (
        can.Bus(interface="virtual", channel=channel) as sender,
        can.Bus(interface="virtual", channel=channel) as receiver,
    ):
        listener = Listener(receiver, RIG, tmp_path / "r.mcap")
        transmit(sender)
        return listener.listen(StopRequest(), duration)


def test_every_frame_is_recorded_none_is_sent_and_samples_are_made_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 2.0)
    monkeypatch.setattr(Reconstructed, "loss", lambda made: "half of it is missing")
    Path("rig.toml").write_text(f'name = "bench"\n[bus]\ninterface = "udp_multicast"\n{DRIVES}')
    listening = threading.Event()

    def opened(settings: object) -> can.BusABC:
        bus = can.Bus(interface="virtual", channel="all")
        listening.set()
        return bus

    monkeypatch.setattr(listen, "open_bus", opened)
    sender, witness = (can.Bus(interface="virtual", channel="all") for _ in range(2))
    thread = threading.Thread(target=lambda: listening.wait(patient(60)) and master(sender, 50))
    thread.start()
    result = invoke(command, "--listen", "--rig", "rig.toml")
    thread.join()
    received = [witness.queue.get() for _ in range(witness.queue.qsize())]
    for bus in (sender, witness):
        bus.shutdown()
    assert "sending nothing" in result.stderr
    assert "warning: half of it is missing\n" in result.stderr
    assert re.search(r"^SYNCs +50 heard, \d+ missing *$", result.stdout, re.MULTILINE)
    assert re.search(r"^motion +not known, does not repeat *$", result.stdout, re.MULTILINE)
    assert result.stdout.splitlines()[-1] == "recorded listened.mcap (listened)"
    assert not re.search(r"None|\[|False", result.stdout), "figures in sentences"

    frames = read_can(Path("listened.mcap"))
    assert frames.id.tolist() == [message.arbitration_id for message in received]
    assert len(frames.id) == 50 * 7 + 1
    assert not frames.sent.any()
    np.testing.assert_allclose(frames.log, [round(message.timestamp * 1e9) for message in received], atol=2e9)
    assert (np.diff(frames.log) >= 0).all()
    recording = read(Path("listened.mcap"))
    known = np.flatnonzero(np.isfinite(recording.position[:, 0]))
    assert len(known) == 50
    counts = (recording.position[known] - recording.position[0]) * RIG.drives[0].counts_per_radian
    np.testing.assert_allclose(counts, np.tile(100.0 * np.arange(50)[:, None], 3), atol=1e-6)
    np.testing.assert_array_equal(recording.command, recording.position)
    np.testing.assert_allclose(recording.voltage[known], 0.05)
    assert (recording.repeat[known] == 0).all()
    run = recording.run
    assert (run.trajectory, run.exit_status, run.reason) == ("listened", 0, "no SYNC for 2 s")
    assert [(event.level, event.source) for event in recording.events] == [("error", "joint 2")]
    assert "0x3210" in recording.events[0].message


@pytest.mark.parametrize(
    ("heard", "duration", "reason"),
    [(0x181, 0.2, "the time to listen was over"), (0x80, 60.0, "no SYNC for 0.2 s")],
)
def test_listening_ends_after_the_duration_or_when_the_syncs_have_ceased(
    heard: int, duration: float, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 0.2)
    assert listened(tmp_path, "end", lambda bus: send(bus, heard, b""), duration) == reason


def test_stall_of_the_listener_is_no_silence_of_the_bus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listen, "SYNC_TIMEOUT", 0.3)
    with (
        can.Bus(interface="virtual", channel="stalled") as sender,
        can.Bus(interface="virtual", channel="stalled") as receiver,
    ):
        listener = Listener(receiver, RIG, tmp_path / "r.mcap")
        send(sender, 0x80, b"")

        def stall(heard: listen.FrameRecorder) -> None:
            if heard.frames == 1:
                send(sender, 0x701, b"\x05")
                send(sender, 0x80, b"")
                time.sleep(0.4)

        assert listener.listen(StopRequest(), 60.0, stall) == "no SYNC for 0.3 s"
        assert listener.syncs == 2


def test_recording_without_sync_keeps_its_frames_and_has_no_samples(tmp_path: Path) -> None:
    listened(tmp_path, "none", lambda bus: send(bus, 0x181, bytes(8)), 0.2)
    with pytest.raises(BadInput, match="holds no samples"):
        read(tmp_path / "r.mcap")
    with pytest.raises(RunFailed, match="no SYNC was heard"):
        listen.complete(tmp_path / "r.mcap", RIG, None, {})
    assert len(read_can(tmp_path / "r.mcap").id) == 1
