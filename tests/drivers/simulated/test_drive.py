import struct

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from drivers.cia402 import Controlword, decode
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.drive_state_machine import PowerState
from recordings.rig import Drive

DT = 2e-4
NODE = 3
SCALE = 0.0005
"""Voltage per count [V]."""
START = bytes([0x01, NODE])


class Bench:
    """A drive with manual frames and time; the encoder follows the setpoint unless held."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.drive = SimulatedCanopenDrive(
            Drive(node_id=NODE, counts_per_turn=10000, gear=1.0),
            DT,
            lambda i, d: self.sent.append((i, d)),
            lambda: 77 * SCALE,
            lockstep=True,
        )
        self.now = 0.0
        self.held_at: int | None = None

    def command(self, controlword: int, target: int = 0) -> None:
        self.drive.receive(0x200 + NODE, struct.pack("<Hi", controlword, target), self.now)

    def sync(self) -> None:
        self.drive.synchronise(self.counts, 123 * SCALE, 1.5)

    @property
    def counts(self) -> int:
        if self.held_at is not None:
            return self.held_at
        return round(self.drive.generator.position * self.drive.drive.counts_per_radian)

    def run(self, duration: float) -> None:
        for _ in range(round(duration / DT)):
            self.drive.generator.step()
            self.now += DT
            if round(self.now / DT) % 10 == 0:
                self.drive.update(self.counts, self.now)

    def cycle(self, controlword: int, target: int = 0) -> None:
        self.command(controlword, target)
        self.sync()
        self.run(0.002)

    def sdo(self, data: str) -> str:
        self.sent.clear()
        self.drive.receive(0x600 + NODE, bytes.fromhex(data), self.now)
        assert self.sent[0][0] == 0x580 + NODE
        return self.sent[0][1].hex(" ")

    def enable(self) -> None:
        self.sdo("2f 60 60 00 08 00 00 00")
        self.drive.receive(0x000, START, self.now)
        for word in (Controlword.SHUTDOWN, Controlword.SWITCH_ON, Controlword.ENABLE):
            self.cycle(word, self.counts)
        assert self.drive.state is PowerState.ENABLED


def test_boots_up_and_serves_its_dictionary() -> None:
    bench = Bench()
    assert bench.sent == [(0x700 + NODE, b"\x00")]
    assert bench.sdo("40 00 10 00 00 00 00 00") == "43 00 10 00 92 01 02 00"
    assert bench.sdo("40 41 60 00 00 00 00 00") == "4b 41 60 00 40 02 00 00"


@pytest.mark.parametrize(
    ("request_", "abort"),
    [
        ("40 00 50 00 00 00 00 00", "80 00 50 00 00 00 02 06"),  # no such object
        ("2b 41 60 00 00 00 00 00", "80 41 60 00 02 00 01 06"),  # read only
        ("2b 60 60 00 08 00 00 00", "80 60 60 00 10 00 07 06"),  # wrong length
        ("23 01 16 01 20 00 00 50", "80 01 16 01 00 00 02 06"),  # no such object to write
        ("23 00 16 01 10 00 41 60", "80 00 16 01 22 00 00 08"),  # while the PDO is valid
        ("23 00 14 01 04 02 00 00", "80 00 14 01 30 00 09 06"),  # likewise, another COB-ID
    ],
)
def test_refused_sdo_requests(request_: str, abort: str) -> None:
    assert Bench().sdo(request_) == abort


def test_only_mappable_objects_of_the_right_length_are_mapped() -> None:
    bench = Bench()
    assert bench.sdo("23 00 14 01 03 02 00 80").startswith("60")
    assert bench.sdo("2f 00 16 00 00 00 00 00").startswith("60")
    assert bench.sdo("23 00 16 01 10 00 40 60").startswith("60")
    assert bench.sdo("23 00 16 02 20 00 40 60") == "80 00 16 02 41 00 04 06"  # 32 bits of 16
    assert bench.sdo("23 00 16 02 20 00 85 60") == "80 00 16 02 41 00 04 06"  # not mappable
    assert bench.sdo("23 00 16 02 20 00 7a 60").startswith("60")
    assert bench.sdo("23 00 16 03 20 01 c1 60").startswith("60")
    assert bench.sdo("2f 00 16 00 03 00 00 00") == "80 00 16 00 42 00 04 06"  # ten bytes


def test_answers_sync_only_when_operational() -> None:
    bench = Bench()
    bench.sent.clear()
    bench.sync()
    assert bench.sent == []
    bench.drive.receive(0x000, START, 0.0)
    bench.sync()
    assert [i for i, _ in bench.sent] == [0x180 + NODE]
    assert struct.unpack("<Hih", bench.sent[0][1]) == (0x240, 0, 123)


def test_no_sdo_when_stopped() -> None:
    bench = Bench()
    bench.drive.receive(0x000, bytes([0x02, 0]), 0.0)
    bench.sent.clear()
    bench.drive.receive(0x600 + NODE, bytes.fromhex("40 00 10 00 00 00 00 00"), 0.0)
    assert bench.sent == []


def test_targets_are_interpolated_linearly() -> None:
    bench = Bench()
    bench.sdo("2f c2 60 01 02 00 00 00")
    bench.enable()
    bench.cycle(Controlword.ENABLE, 100)
    assert bench.counts == 100
    assert bench.drive.statusword & 0x1000


def test_enabling_does_not_move_to_an_old_target() -> None:
    bench = Bench()
    bench.drive.receive(0x000, START, 0.0)
    bench.cycle(Controlword.SHUTDOWN, 5000)
    bench.cycle(Controlword.SWITCH_ON, 5000)
    bench.command(Controlword.ENABLE, 0)
    bench.sync()
    assert bench.drive.state is PowerState.ENABLED
    assert bench.drive.generator.position == 0.0


def test_quick_stop_decelerates_on_its_ramp_and_switches_power_off() -> None:
    bench = Bench()
    bench.sdo("2f c2 60 01 02 00 00 00")  # 2 ms
    bench.sdo("23 85 60 00 a0 86 01 00")  # 100,000 counts/s^2
    bench.enable()
    for k in range(1, 50):
        bench.cycle(Controlword.ENABLE, 20 * k)  # 10,000 counts/s
    start = bench.counts
    bench.cycle(Controlword.QUICK_STOP, 0)
    assert bench.drive.state is PowerState.QUICK_STOP
    assert bench.drive.powered
    bench.run(0.12)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED
    assert not bench.drive.powered
    assert bench.counts - start == pytest.approx(10_000**2 / 2 / 100_000, rel=0.05)


def test_following_error_is_a_fault_with_emcy() -> None:
    bench = Bench()
    bench.sdo("23 65 60 00 64 00 00 00")
    bench.enable()
    bench.held_at = bench.counts
    bench.sent.clear()
    for k in range(20):
        bench.cycle(Controlword.ENABLE, 50 * k)
    assert (0x80 + NODE, bytes.fromhex("1186010000000000")) in bench.sent
    bench.run(0.5)
    assert bench.drive.state is PowerState.FAULT
    assert decode(bench.drive.statusword).name == "FAULT"


def test_fault_is_reset_by_the_rising_edge() -> None:
    bench = Bench()
    bench.drive.receive(0x000, START, 0.0)
    bench.drive.fail(0x2310)
    assert bench.drive.state is PowerState.FAULT
    bench.cycle(Controlword.ENABLE)
    assert bench.drive.state is PowerState.FAULT
    bench.sent.clear()
    bench.cycle(Controlword.FAULT_RESET)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED
    assert (0x80 + NODE, bytes(8)) in bench.sent


def test_lost_master_stops_the_drive() -> None:
    bench = Bench()
    bench.sdo("23 16 10 01 fa 00 7f 00")  # node 127, 250 ms
    bench.sdo("2b 07 60 00 03 00 00 00")
    bench.drive.receive(0x77F, b"\x05", bench.now)
    bench.enable()
    bench.run(0.2)
    assert bench.drive.state is PowerState.ENABLED
    bench.sent.clear()
    bench.run(0.3)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED
    assert (0x80 + NODE, bytes.fromhex("3081110000000000")) in bench.sent


def test_heartbeat_contains_the_nmt_state() -> None:
    bench = Bench()
    bench.sdo("2b 17 10 00 64 00 00 00")
    bench.drive.receive(0x000, START, 0.0)
    bench.sent.clear()
    bench.run(1.0)
    assert [frame for frame in bench.sent if frame[0] == 0x700 + NODE] == [(0x700 + NODE, b"\x05")] * 10


def test_reset_boots_again_without_power() -> None:
    bench = Bench()
    bench.enable()
    bench.sent.clear()
    bench.drive.receive(0x000, bytes([0x81, NODE]), bench.now)
    assert bench.sent == [(0x700 + NODE, b"\x00")]
    assert not bench.drive.powered


class AnyTraffic(RuleBasedStateMachine):
    """With any frames on the bus, the drive has torque only in the states that permit it."""

    @initialize()
    def switch_on(self) -> None:
        self.bench = Bench()
        self.previous = self.bench.drive.state

    @rule(command=st.sampled_from([0x01, 0x02, 0x80, 0x81, 0x82]), node=st.sampled_from([0, NODE, 5]))
    def nmt(self, command: int, node: int) -> None:
        self.bench.drive.receive(0x000, bytes([command, node]), self.bench.now)

    @rule(
        word=st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x80]) | st.integers(0, 0xFFFF),
        goal=st.integers(-500, 500),
    )
    def cycle(self, word: int, goal: int) -> None:
        before = self.bench.drive.state
        self.bench.cycle(word, goal)
        if self.bench.drive.state is PowerState.ENABLED:
            assert before in (PowerState.SWITCHED_ON, PowerState.ENABLED)

    @rule(data=st.binary(min_size=0, max_size=8))
    def garbled(self, data: bytes) -> None:
        for arbitration_id in (0x000, 0x200 + NODE, 0x600 + NODE, 0x77F):
            self.bench.drive.receive(arbitration_id, data, self.bench.now)

    @rule()
    def fault(self) -> None:
        self.bench.drive.fail(0x4310)
        assert self.bench.drive.state in (PowerState.FAULT, PowerState.FAULT_REACTION)

    @rule()
    def pass_time(self) -> None:
        self.bench.run(0.3)

    @invariant()
    def statusword_tells_the_truth(self) -> None:
        assert decode(self.bench.drive.statusword).name == self.bench.drive.state.name


AnyTraffic.TestCase.settings = settings(max_examples=40, stateful_step_count=25, deadline=None)
test_any_traffic = AnyTraffic.TestCase
