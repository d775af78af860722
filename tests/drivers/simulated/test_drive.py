"""The simulated CANopen drive: its objects and PDOs, how it stops, fails, and notices a lost master."""

from pathlib import Path

import pytest

from drivers.cia402 import Controlword
from drivers.simulated.drive_state_machine import PowerState
from tests.drivers.simulated.bench import INCREMENTS, NODE, TPDO, Bench, made_up
from tests.drivers.simulated.dictionaries import (
    GEAR,
    I8,
    RPM,
    RPM_PER_SECOND,
    U8,
    U16,
    U32,
    Item,
    base,
    four_tpdos,
    pdo,
)

# Objects


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


# Targets


@pytest.mark.parametrize(("unit", "speed"), [(RPM, 20), (0x0041_4700, 7219), (0x0041_0300, 120)])
def test_homing_has_its_speed_in_the_units_of_the_drive(unit: int, speed: int, tmp_path: Path) -> None:
    """0.1 rad/s of the joint in rpm, in degrees per minute and in degrees per second of the motor."""
    homing = {(0x6098, 0): Item(I8, default=17), (0x6099, 1): Item(U32, default=speed)}
    bench = made_up(tmp_path, base(modes=0xE0) | homing | {(0x60A9, 0): Item(U32, default=unit)})
    bench.enable()
    bench.write(0x6060, "b", 6)
    bench.cycle(Controlword.ENABLE | 0x10)
    start = bench.drive.generator.position
    bench.run(0.1)
    assert bench.drive.generator.position - start == pytest.approx(0.01, rel=0.01)


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


# Stops


@pytest.mark.parametrize(
    ("option", "afterwards"), [(2, PowerState.SWITCH_ON_DISABLED), (6, PowerState.QUICK_STOP), (0, None)]
)
def test_a_quick_stop_ends_as_its_option_says(option: int, afterwards: PowerState | None, tmp_path: Path) -> None:
    bench = made_up(tmp_path)
    bench.write(0x605A, "h", option)
    bench.enable()
    bench.move(1.0)
    bench.cycle(Controlword.QUICK_STOP)
    assert bench.drive.powered == (afterwards is not None)
    bench.run(1.0)
    assert bench.state is (afterwards or PowerState.SWITCH_ON_DISABLED)


@pytest.mark.parametrize(
    ("unit", "object_value", "speed"),
    [(0, 10 * INCREMENTS, 1.0), (RPM_PER_SECOND, 10 * GEAR * 60 / (2 * 3.141592653589793), -1.0)],
)
def test_a_quick_stop_has_its_deceleration_in_the_units_of_the_drive(
    unit: int, object_value: float, speed: float, tmp_path: Path
) -> None:
    bench = made_up(tmp_path, base() | ({(0x60AA, 0): Item(U32, default=unit)} if unit else {}))
    bench.write(0x6085, "I", round(object_value))
    bench.enable()
    bench.move(speed)
    start = bench.drive.generator.position
    bench.cycle(Controlword.QUICK_STOP)
    assert bench.state is PowerState.QUICK_STOP
    bench.run(0.5)
    assert bench.drive.generator.position - start == pytest.approx(speed / (2 * 10), rel=0.05)


def test_without_605a_and_6085_a_quick_stop_is_as_hard_as_the_drive_can(tmp_path: Path) -> None:
    bench = made_up(tmp_path, {a: item for a, item in base().items() if a[0] not in (0x605A, 0x6085)})
    bench.enable()
    bench.move(1.0)
    bench.cycle(Controlword.QUICK_STOP)
    assert bench.state is PowerState.QUICK_STOP
    bench.run(0.01)
    assert bench.state is PowerState.SWITCH_ON_DISABLED


# Faults


def test_following_error_is_a_fault_with_emcy() -> None:
    bench = Bench()
    bench.write(0x6065, "I", 100)
    bench.enable()
    bench.held_at = bench.counts
    for k in range(20):
        bench.cycle(Controlword.ENABLE, 50 * k)
    assert (0x80 + NODE, bytes.fromhex("1186010000000000")) in bench.sent
    bench.run(0.5)
    assert bench.state is PowerState.FAULT


# Watchdogs


def test_after_a_lost_master_only_reset_communication_makes_a_fault_resettable(tmp_path: Path) -> None:
    bench = made_up(tmp_path, reset_after_heartbeat_loss=False, fault_on_heartbeat_loss=True)
    bench.write(0x1016, "I", 127 << 16 | 100, sub=1)
    bench.run(0.2)
    bench.drive.receive(0x77F, b"\5", bench.now)
    bench.enable()
    bench.run(0.05)
    assert bench.state is PowerState.ENABLED
    bench.run(0.5)
    assert (0x80 + NODE, bytes.fromhex("3081110000000000")) in bench.sent
    assert bench.state is PowerState.FAULT
    assert bench.read(0x603F) == 0x8130
    bench.write(0x6040, "H", Controlword.FAULT_RESET)
    bench.nmt(0x82)
    assert bench.state is PowerState.FAULT
    for word in (Controlword.DISABLE_VOLTAGE, Controlword.FAULT_RESET):
        bench.write(0x6040, "H", word)
    assert bench.state is PowerState.SWITCH_ON_DISABLED


def test_guarding_is_answered_and_its_loss_noticed(tmp_path: Path) -> None:
    guarding = {(0x100C, 0): Item(U16, default=50), (0x100D, 0): Item(U8, default=2)}
    bench = made_up(tmp_path, base() | guarding)
    bench.write(0x6007, "h", 3)
    bench.enable()
    for expected in (0x05, 0x85, 0x05):
        bench.drive.receive_remote(0x700 + NODE, bench.now)
        assert bench.sent[-1] == (0x700 + NODE, bytes([expected]))
        bench.run(0.09)
    assert bench.state is PowerState.ENABLED
    bench.run(0.3)
    assert (0x80 + NODE, bytes.fromhex("3081110000000000")) in bench.sent
    assert bench.state is PowerState.SWITCH_ON_DISABLED


def test_a_lost_rpdo_is_noticed_where_the_drive_has_a_timer(tmp_path: Path) -> None:
    bench = made_up(tmp_path, base() | {(0x1400, 5): Item(U16, default=20)})
    bench.write(0x6007, "h", 3)
    bench.enable()
    bench.run(0.3)
    assert (0x80 + NODE, bytes.fromhex("5082110000000000")) in bench.sent
    assert bench.state is PowerState.SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    ("option", "state"),
    [
        (0, PowerState.ENABLED),
        (1, PowerState.FAULT),
        (2, PowerState.SWITCH_ON_DISABLED),
        (3, PowerState.SWITCH_ON_DISABLED),
    ],
)
def test_reactions_to_the_end_of_process_data(option: int, state: PowerState) -> None:
    bench = Bench()
    bench.write(0x6007, "h", option)
    bench.enable()
    bench.nmt(0x80)
    bench.run(0.1)
    assert bench.state is state
