"""The simulated CANopen drive: how it stops, fails, and notices a lost master."""

from pathlib import Path

import pytest

from drivers.cia402 import Controlword
from drivers.simulated.drive_state_machine import PowerState
from tests.drivers.simulated.bench import INCREMENTS, NODE, Bench, made_up
from tests.drivers.simulated.dictionaries import (
    GEAR,
    RPM_PER_SECOND,
    U8,
    U16,
    U32,
    Item,
    base,
)

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


@pytest.mark.parametrize(("delay", "cycles"), [(0.0, 0), (0.1, 49)])
def test_fault_is_reset_by_the_rising_edge_and_its_time(delay: float, cycles: int, tmp_path: Path) -> None:
    bench = made_up(tmp_path, fault_at_power_on=0x3220, fault_reset=delay)
    assert (0x80 + NODE, bytes.fromhex("2032010000000000")) in bench.sent
    bench.start()
    bench.cycle(Controlword.ENABLE)
    assert bench.state is PowerState.FAULT
    bench.sent.clear()
    bench.cycle(Controlword.FAULT_RESET, cycles=cycles)
    assert bench.state is PowerState.FAULT
    bench.cycle(Controlword.FAULT_RESET, cycles=2)
    assert bench.state is PowerState.SWITCH_ON_DISABLED
    assert (0x80 + NODE, bytes(8)) in bench.sent


def test_in_lockstep_sdo_requests_pass_time_for_a_reset(tmp_path: Path) -> None:
    bench = made_up(tmp_path, fault_at_power_on=0x2310, fault_reset=0.1)
    bench.write(0x6040, "H", Controlword.FAULT_RESET)
    for _ in range(98):
        bench.read(0x6041)
    assert bench.state is PowerState.FAULT
    for _ in range(3):
        bench.read(0x6041)
    assert bench.state is PowerState.SWITCH_ON_DISABLED


def test_a_warning_is_no_fault() -> None:
    bench = Bench()
    bench.enable()
    bench.drive.warn(0x4210)
    assert bench.sent[-1] == (0x80 + NODE, bytes.fromhex("1042000000000000"))
    assert bench.state is PowerState.ENABLED
    assert bench.drive.statusword & 0x80


def test_referenced_is_a_bit_of_the_statusword_and_enabling_takes_its_time(tmp_path: Path) -> None:
    bench = made_up(tmp_path, base(modes=0x3A0), referenced_mask=0x8000, referenced=False, enabling=0.05)
    assert not bench.drive.statusword & 0x8000
    bench.start()
    bench.write(0x6060, "b", 6)
    bench.cycle(Controlword.SHUTDOWN)
    bench.cycle(Controlword.SWITCH_ON)
    bench.cycle(Controlword.ENABLE, cycles=20)
    assert bench.state is PowerState.SWITCHED_ON
    bench.cycle(Controlword.ENABLE, cycles=10)
    bench.cycle(Controlword.ENABLE | 0x10)
    assert bench.drive.statusword & 0x9400 == 0x9400


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
