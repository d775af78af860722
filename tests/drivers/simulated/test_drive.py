"""The simulated CANopen drive: its objects, PDOs and targets, with any frames on the bus."""

import struct
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from drivers.cia402 import Controlword, decode
from drivers.simulated.drive_state_machine import PowerState
from recordings.rig import Drive
from tests.drivers.simulated.bench import NODE, TPDO, Bench, made_up
from tests.drivers.simulated.dictionaries import (
    CURRENT,
    GEAR,
    INCREMENTS_PER_TURN,
    MADE_UP,
    TORQUE,
    U8,
    U16,
    U32,
    Item,
    base,
    four_tpdos,
    pdo,
)

# Objects


def test_boots_up_and_serves_its_dictionary_marked_as_simulated() -> None:
    bench = Bench()
    assert bench.sent == [(0x700 + NODE, b"\x00")]
    assert (bench.read(0x1000), bench.read(0x6041)) == (0x20192, 0x240)
    assert bench.read(0x5FFF, 1) == 1
    assert bench.read(0x5FFF, 3) == len("delta-workbench simulated drive")  # the length of a segmented transfer


def test_reads_and_writes_are_answered_or_aborted_as_in_cia_301(tmp_path: Path) -> None:
    items = base(modes=0x80) | {(0x1024, 0): Item(U8, "wo"), (0x2005, 0): Item(U32, default=None)}
    habits = {"allowed": {"605A": [6]}, "refuse_write": ["1006"], "refuse_read": ["1008"], "values": {"6066": 33}}
    bench = made_up(tmp_path, items, **habits)
    reads = {
        **{(0x6085, 0): 100_000, (0x6066, 0): 33, (0x2005, 0): 0},
        **{(0x5000, 0): -0x06020000, (0x6085, 1): -0x06090011, (0x1024, 0): -0x06010001, (0x1008, 0): -0x08000020},
    }
    assert {address: bench.read(*address) for address in reads} == reads
    writes = {
        **{(0x6085, "I", 5): 0, (0x1024, "B", 5): 0, (0x605A, "h", 6): 0, (0x6060, "b", 8): 0},
        **{(0x6041, "H", 5): -0x06010002, (0x6085, "H", 5): -0x06070010, (0x6007, "h", 4): -0x06090031},
        **{(0x6007, "h", -1): -0x06090032, (0x605A, "h", 2): -0x06090030, (0x1006, "I", 2000): -0x08000020},
        **{(0x5000, "I", 2000): -0x06020000, (0x6060, "b", 1): -0x06090030},
    }
    assert {write: bench.try_to_write(*write) for write in writes} == writes
    assert (bench.read(0x6085), bench.read(0x6061)) == (5, 8)
    assert bench.try_to_write(0x6085, "I", 2000, sub=3) == -0x06090011


def test_only_mappable_objects_of_the_right_length_are_mapped_into_a_pdo_that_is_off() -> None:
    bench, no_pdo, cob_id = Bench(), 0x8000_0203, 0x1400
    assert bench.try_to_write(0x1600, "I", 0x6041_0010, 1) == -0x08000022  # while the PDO is valid
    assert bench.try_to_write(cob_id, "I", 0x204, 1) == -0x06090030  # likewise, another COB-ID
    bench.write(cob_id, "I", no_pdo, 1)
    bench.write(0x1600, "B", 0)
    for sub, entry, answer in (
        (1, 0x6040_0010, 0),
        (2, 0x6040_0020, -0x06040041),  # 32 bits of 16
        (2, 0x6085_0020, -0x06040041),  # not mappable
        (2, 0x607A_0020, 0),
        (3, 0x60C1_0120, 0),
    ):
        assert bench.try_to_write(0x1600, "I", entry, sub) == answer
    assert bench.try_to_write(0x1600, "B", 3) == -0x06040042  # ten bytes
    bench.nmt(0x01)
    assert bench.try_to_write(0x1600, "B", 2) == -0x08000022


def test_reset_restores_values_and_takes_power_and_reset_communication_only_its_objects() -> None:
    bench = Bench()
    bench.write(0x1017, "H", 100)
    bench.write(0x6066, "H", 5)
    bench.enable()
    bench.nmt(0x82)
    assert (bench.read(0x1017), bench.read(0x6066)) == (0, 5)
    assert bench.drive.powered
    bench.sent.clear()
    bench.nmt(0x81)
    assert bench.sent == [(0x700 + NODE, b"\x00")]
    assert not bench.drive.powered
    assert bench.read(0x6066) != 5


def test_units_ratings_and_bits_of_cob_ids_are_those_of_the_drive(tmp_path: Path) -> None:
    bench = made_up(tmp_path, base() | TORQUE | CURRENT, cob_id_bits=0x4000_0000)
    bench.torque = 0.952 * GEAR / 2
    bench.sync()
    assert (bench.read(0x6077), bench.read(0x6078), bench.read(0x1400, 1)) == (500, 500, 0x4000_0203)
    without_rating = made_up(tmp_path, base() | TORQUE | {(0x6076, 0): Item(U32, default=0)})
    assert without_rating.read(0x6076) == round(1000 * Drive(node_id=1).rated_torque / GEAR)
    degrees = made_up(tmp_path, MADE_UP["one_millisecond"].items)
    degrees.enable()
    degrees.cycle(Controlword.ENABLE, 90_000, cycles=3)  # a quarter of a turn of the motor, in 1/360,000 turn
    assert degrees.counts == pytest.approx(INCREMENTS_PER_TURN / 4, abs=1)
    assert degrees.read(0x6064) == pytest.approx(90_000, abs=44)


# Network management


def test_answers_sync_only_when_operational_and_sdo_unless_stopped() -> None:
    bench = Bench()
    bench.sent.clear()
    bench.sync()
    assert bench.sent == []
    bench.nmt(0x01)
    bench.sync()
    assert [(i, struct.unpack("<Hih", data)) for i, data in bench.sent] == [(0x180 + NODE, (0x240, 0, 123))]
    bench.sent.clear()
    bench.nmt(0x02)
    bench.drive.receive(0x600 + NODE, bytes.fromhex("4000100000000000"), 0.0)
    assert bench.sent == []


def test_heartbeat_contains_the_nmt_state() -> None:
    bench = Bench()
    bench.write(0x1017, "H", 100)
    bench.nmt(0x01)
    bench.sent.clear()
    bench.run(0.99)
    assert bench.sent == [(0x700 + NODE, b"\x05")] * 10


# Targets


def test_targets_are_interpolated_within_limits_and_an_old_one_moves_nothing() -> None:
    bench = Bench()
    for sub, limit in ((1, -50), (2, 400)):
        bench.write(0x607D, "i", limit, sub)
    bench.start()
    bench.held_at = 300
    bench.cycle(Controlword.SHUTDOWN, 5000)
    bench.cycle(Controlword.SWITCH_ON, 5000)
    bench.cycle(Controlword.ENABLE, 300)
    assert bench.state is PowerState.ENABLED
    bench.held_at = None
    assert bench.counts == 300
    for target, reached in ((100, 100), (500, 400)):
        bench.cycle(Controlword.ENABLE, target)
        assert bench.counts == reached
    assert bench.drive.statusword & 0x1000


def test_without_60c2_targets_are_interpolated_over_the_time_between_syncs(tmp_path: Path) -> None:
    bench = made_up(tmp_path, {a: item for a, item in base().items() if a[0] != 0x60C2})
    bench.enable()
    bench.command(Controlword.ENABLE, 1000)
    bench.drive.synchronise(0, 0.0, 0.0, bench.now)
    for _ in range(5):
        bench.drive.generator.step()
    assert bench.counts == pytest.approx(500, abs=1)


@pytest.mark.parametrize("sign", [1, -1])
def test_torque_offset_acts_in_the_direction_of_the_drive_while_the_loops_are_closed(sign: int) -> None:
    bench = Bench()
    bench.drive.drive = bench.drive.drive.model_copy(update={"sign": sign})
    bench.write(0x60B2, "h", 250)
    assert bench.drive.torque_offset == 0.0
    bench.enable()
    # A quarter of the rated torque of 20 N m at the joint.
    assert bench.drive.torque_offset == pytest.approx(sign * 5.0)
    bench.cycle(Controlword.QUICK_STOP)
    bench.run(0.5)
    bench.cycle(Controlword.DISABLE_VOLTAGE)
    assert bench.drive.torque_offset == 0.0


# PDOs by events


def test_tpdos_are_sent_on_a_change_from_power_up_on_by_a_timer_or_every_nth_sync(tmp_path: Path) -> None:
    bench = made_up(tmp_path, base() | four_tpdos())
    bench.nmt(0x01)
    bench.run(0.1)
    tpdos = [0x180 + NODE, 0x280 + NODE, 0x380 + NODE, 0x480 + NODE]
    assert [arbitration_id for arbitration_id, _ in bench.sent[1:]] == tpdos
    bench.sent.clear()
    bench.cycle(Controlword.SHUTDOWN)
    assert [arbitration_id for arbitration_id, _ in bench.sent] == tpdos[:3]
    items = base() | pdo(0, False, TPDO, kind=3) | pdo(1, False, TPDO, kind=255)
    bench = made_up(tmp_path, items | {(0x1801, 5): Item(U16, default=10)})
    bench.nmt(0x01)
    for _ in range(30):
        bench.sync()
    ids = [arbitration_id for arbitration_id, _ in bench.sent]
    assert (ids.count(tpdos[0]), ids.count(tpdos[1])) == (10, pytest.approx(6, abs=1))


class AnyTraffic(RuleBasedStateMachine):
    """With any frames on the bus, the drive has torque only in the states that permit it."""

    @initialize()
    def switch_on(self) -> None:
        self.bench = Bench()

    @rule(command=st.sampled_from([0x01, 0x02, 0x80, 0x81, 0x82]), node=st.sampled_from([0, NODE, 5]))
    def nmt(self, command: int, node: int) -> None:
        self.bench.drive.receive(0x000, bytes([command, node]), self.bench.now)

    @rule(
        word=st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x80]) | st.integers(0, 0xFFFF),
        goal=st.integers(-500, 500),
    )
    def cycle(self, word: int, goal: int) -> None:
        before = self.bench.state
        self.bench.cycle(word, goal)
        if self.bench.state is PowerState.ENABLED:
            assert before in (PowerState.SWITCHED_ON, PowerState.ENABLED)

    @rule(data=st.binary(min_size=0, max_size=8))
    def garbled(self, data: bytes) -> None:
        for arbitration_id in (0x000, 0x200 + NODE, 0x600 + NODE, 0x77F):
            self.bench.drive.receive(arbitration_id, data, self.bench.now)

    @rule()
    def fault(self) -> None:
        self.bench.drive.fail(0x4310)
        assert self.bench.state in (PowerState.FAULT, PowerState.FAULT_REACTION)

    @rule()
    def pass_time(self) -> None:
        self.bench.run(0.3)

    @invariant()
    def statusword_tells_the_truth(self) -> None:
        assert decode(self.bench.drive.statusword).name == self.bench.state.name


AnyTraffic.TestCase.settings = settings(max_examples=40, stateful_step_count=25, deadline=None)
test_any_traffic = AnyTraffic.TestCase
