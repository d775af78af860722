"""Replay of recorded frames: selection, order, timing, and rejected options."""

import errno
import json
import signal

import can
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.commands.replay import command
from daq.cycle.stopping import StopRequest
from daq.passive import replay as module
from daq.passive.replay import ReplayPlan, commanding, matching, plan, replay
from recordings.errors import BadInput, RunFailed
from recordings.reader import read_can
from recordings.recording import CanFrames, Floats
from tests.daq.passive.listening import SAMPLE
from tests.running import invoke, ran
from tests.simulated_time import SimulatedTime, simulate_time


def frames(ids: list[int], log: list[int], **flags: list[bool]) -> CanFrames:
    """CAN frames with their number as data."""
    n = len(ids)
    no = [False] * n
    data = np.zeros((n, 8), np.uint8)
    data[:, 0] = np.arange(n) % 256
    time = np.array(log, np.int64)
    return CanFrames(
        stamp=time,
        log=time,
        id=np.array(ids, np.int64),
        dlc=np.ones(n, np.int64),
        data=data,
        **{name: np.array(flags.get(name, no), bool) for name in ("sent", "rtr", "extended", "error")},
    )


def planned(recorded: CanFrames, speed: float = 1.0, loops: int = 1, bitrate: int = 1_000_000) -> ReplayPlan:
    return plan(recorded, matching(recorded, "both", []), speed, loops, bitrate)


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> SimulatedTime:
    return simulate_time(monkeypatch, module)


def replayed(plan_: ReplayPlan, channel: str) -> list[can.Message]:
    """What another node on a virtual bus receives."""
    with can.Bus(interface="virtual", channel=channel) as bus, can.Bus(interface="virtual", channel=channel) as node:
        assert replay(plan_, bus, StopRequest()).sent == plan_.total == node.queue.qsize()
        return [node.queue.get() for _ in range(plan_.total)]


class Wire:
    """Bus that notes when each frame was sent [s]."""

    def __init__(self) -> None:
        self.clock, self.sent = SimulatedTime(), list[float]()

    def send(self, message: can.Message) -> None:
        self.sent.append(self.clock.now)


def sent_at(plan_: ReplayPlan) -> Floats:
    """When each frame is sent, after the first [s]."""
    wire = Wire()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "time", wire.clock)
        assert replay(plan_, wire, StopRequest()).lateness == pytest.approx(0.0, abs=1e-9)  # type: ignore[arg-type]
    return np.array(wire.sent) - wire.sent[0]


def test_frames_arrive_in_order_with_all_their_bits() -> None:
    recorded = frames(
        [0x80, 0x181, 0x12345, 0x55, 0x7FF],
        [0, 1_000_000, 1_000_000, 3_000_000, 3_500_000],
        extended=[False, False, True, False, False],
        rtr=[False, False, False, True, False],
    )
    messages = replayed(planned(recorded), "order")
    assert [message.arbitration_id for message in messages] == recorded.id.tolist()
    assert [message.is_extended_id for message in messages] == recorded.extended.tolist()
    assert [message.is_remote_frame for message in messages] == recorded.rtr.tolist()
    assert [bytes(message.data) for message in messages] == [b"\x00", b"\x01", b"\x02", b"", b"\x04"]
    assert (np.diff([message.timestamp for message in messages]) >= 0).all()


@given(
    steps=st.lists(st.integers(0, 3_000_000), min_size=1, max_size=15),
    speed=st.floats(0.5, 8),
    loops=st.integers(1, 3),
)
@settings(deadline=None, max_examples=10)
def test_deadlines_are_the_recorded_times_divided_by_the_speed(steps: list[int], speed: float, loops: int) -> None:
    log = np.cumsum([0, *steps]).tolist()
    recorded = frames([0x181] * len(log), log)
    plan_ = planned(recorded, speed, loops)
    np.testing.assert_allclose(plan_.due, np.array(log) / 1e9 / speed)
    loop_times = np.repeat(plan_.loop_time * np.arange(loops), len(log))
    sent = sent_at(plan_)
    # Later only as long as the wire needs for the frames before.
    late = sent - loop_times - np.tile(plan_.due, loops)
    assert late.min() >= -1e-9
    assert late.max() <= loops * plan_.wire.sum()
    assert sent[-1] >= plan_.duration - 1e-9


def test_frames_of_one_instant_are_sent_no_faster_than_the_wire() -> None:
    recorded = frames([0x601] * 400, [0] * 400)
    plan_ = planned(recorded, bitrate=125_000)
    # 65 bits each at 125 kbit/s; frames may be sent up to five milliseconds ahead of the wire.
    assert sent_at(plan_)[-1] == pytest.approx(399 * 65 / 125_000 - 0.005)


def test_loops_continue_the_rhythm_of_the_syncs() -> None:
    recorded = frames([0x80, 0x181, 0x80, 0x181], [0, 300_000, 2_000_000, 2_300_000])
    plan_ = planned(recorded, loops=3)
    assert plan_.loop_time == pytest.approx(0.0023 + 0.002)
    assert [message.arbitration_id for message in replayed(plan_, "loop")] == [0x80, 0x181] * 6


@pytest.mark.parametrize(
    ("direction", "ids", "expected"),
    [
        ("both", [], [0, 1, 2, 3]),
        ("tx", [], [0, 2]),
        ("rx", [], [1, 3]),
        ("both", ["0x181"], [1]),
        ("both", ["385"], [1]),
        ("both", ["0x180-0x182"], [1, 3]),
        ("both", ["0x180/0x780"], [1, 3]),
        ("both", ["0x80", " 0x182 "], [0, 3]),
        ("tx", ["0x181"], []),
    ],
)
def test_frames_are_chosen_by_direction_and_id(direction: str, ids: list[str], expected: list[int]) -> None:
    recorded = frames(
        [0x80, 0x181, 0x201, 0x182, 0x0],
        [0] * 5,
        sent=[True, False, True, False, False],
        error=[False, False, False, False, True],
    )
    assert np.flatnonzero(matching(recorded, direction, ids)).tolist() == expected


@pytest.mark.parametrize("text", ["", "x", "0x", "181h", "0x182-0x181", "0x181-", "0x1/0x2/0x3", "-1", "0181"])
def test_malformed_ids_are_rejected(text: str) -> None:
    with pytest.raises(BadInput, match="--id"):
        matching(frames([1], [0]), "both", [text])


def test_commanding_frames_are_recognised_in_any_recording() -> None:
    ids = [0x000, 0x080, 0x081, 0x181, 0x201, 0x301, 0x501, 0x581, 0x601, 0x701, 0x77F]
    recorded = frames(ids, [0] * len(ids))
    expected = [True, True, False, False, True, True, True, False, True, False, True]
    assert commanding(recorded).tolist() == expected
    assert commanding(frames([0x181, 0x201], [0, 0], sent=[True, False], extended=[False, True])).tolist() == [
        True,
        False,
    ]


def test_stop_request_ends_the_replay_at_once(clock: SimulatedTime) -> None:
    recorded = frames([0x181] * 3, [0, 1_000_000, 3_600_000_000_000])
    stop, begin = StopRequest(), clock.now
    clock.at(0.25, lambda: stop.ask("enough"))
    with can.Bus(interface="virtual", channel="stop") as bus:
        result = replay(planned(recorded), bus, stop)
    assert (result.sent, result.stopped) == (2, "enough")
    assert clock.now - begin < 0.4


class FullBus:
    """Bus with a queue that is full `times` times before it accepts a frame."""

    def __init__(self, times: int, code: int = errno.ENOBUFS) -> None:
        self.refusals, self.sent = [can.CanOperationError("no buffer space", code)] * times, 0

    def send(self, message: can.Message) -> None:
        if self.refusals:
            raise self.refusals.pop()
        self.sent += 1


def test_replay_waits_for_a_full_queue_but_not_for_a_lost_bus() -> None:
    plan_, bus = planned(frames([0x181], [0])), FullBus(20)
    replay(plan_, bus, StopRequest())  # type: ignore[arg-type]
    assert bus.sent == 1
    with pytest.raises(RunFailed, match="does not accept frames"):
        replay(plan_, FullBus(1, errno.ENETDOWN), StopRequest())  # type: ignore[arg-type]


def test_command_announces_the_replay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.canopen.bus.open_bus", lambda settings: can.Bus(interface="virtual", channel="cli"))
    arguments = [SAMPLE, "--bus", "udp_multicast:239.74.163.9:43200", "--speed", "1000"]
    result = invoke(command, *arguments, "--id", "0x181", "--json")
    figures = json.loads(result.stdout)
    assert figures["frames"] == figures["frames_planned"] == int((read_can(SAMPLE).id == 0x181).sum())
    assert "COMMAND DRIVES" not in result.stderr
    result = invoke(command, *arguments, "--id", "0x80", "--direction", "tx", "--yes")
    assert "COMMAND DRIVES: any real drive on this bus will move" in result.stderr
    assert "frames: 2840 of 2840" in result.stdout
    assert f"next: daq info {SAMPLE}" in result.stderr


def test_commands_to_drives_are_refused_where_nothing_can_ask_to_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("drivers.canopen.bus.open_bus", lambda settings: can.Bus(interface="virtual", channel="cli"))
    monkeypatch.delattr(signal, "SIGHUP")
    arguments = [SAMPLE, "--bus", "udp_multicast:239.74.163.9:43200", "--speed", "1000", "--direction"]
    with pytest.raises(BadInput, match="asked to stop, as Linux, expected"):
        ran(command, *arguments, "tx", "--id", "0x80", "--yes")
    ran(command, *arguments, "rx", "--id", "0x181")
