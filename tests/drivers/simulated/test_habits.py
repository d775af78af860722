"""Simulated drives with habits: faults that end late, stops that stay powered, PDOs and watchdogs of all kinds."""

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from drivers.cia402 import Controlword
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.drive_state_machine import PowerState
from drivers.simulated.habits import Habits, habits_from
from recordings.config import validated
from recordings.errors import BadInput
from recordings.rig import Drive
from tests.drivers.simulated.dictionaries import (
    CURRENT,
    GEAR,
    INCREMENTS_PER_TURN,
    MADE_UP,
    RPM_PER_SECOND,
    TORQUE,
    U8,
    U16,
    U32,
    Item,
    MadeUpDrive,
    base,
    four_tpdos,
    pdo,
)

DT, PERIOD, NODE = 2e-4, 2e-3, 3
INCREMENTS = INCREMENTS_PER_TURN * GEAR / (2 * 3.141592653589793)
"""Encoder increments per radian of the joint."""
RPDO, TPDO = [0x6040_00_10, 0x607A_00_20], [0x6041_00_10, 0x6064_00_20]


class Bench:
    """An operational drive whose motor follows its setpoints, with manual frames and time."""

    def __init__(self, folder: Path, items: Mapping[Any, Item], **habits: Any) -> None:
        eds, _ = MadeUpDrive({**items, **pdo(0, True, RPDO, kind=1)}).write(folder)
        self.sent: list[tuple[int, bytes]] = []
        self.now = 0.0
        self.drive = SimulatedCanopenDrive(
            Drive(node_id=NODE),
            DT,
            lambda arbitration_id, data: self.sent.append((arbitration_id, data)),
            lambda: 0.0,
            lockstep=True,
            eds=eds,
            habits=validated(habits, Habits, "test"),
        )
        self.torque = 0.0
        self.write(0x6060, "b", 8)
        if (0x60C2, 1) in items and items[0x60C2, 1].high is None:
            self.write(0x60C2, "B", 2, sub=1)
        self.drive.receive(0x000, bytes([0x01, NODE]), self.now)

    def write(self, index: int, layout: str, value: int, sub: int = 0) -> None:
        data = struct.pack(f"<{layout}", value)
        request = struct.pack("<BHB", 0x23 | 4 - len(data) << 2, index, sub) + data.ljust(4, b"\0")
        self.drive.receive(0x600 + NODE, request, self.now)
        assert self.sent[-1][1][0] == 0x60, self.sent[-1]

    def read(self, index: int, layout: str = "H", sub: int = 0) -> int:
        self.drive.receive(0x600 + NODE, struct.pack("<BHB4x", 0x40, index, sub), self.now)
        (value,) = struct.unpack_from(f"<{layout}", self.sent[-1][1], 4)
        return int(value)

    @property
    def counts(self) -> int:
        return round(self.drive.generator.position * INCREMENTS)

    def cycle(self, word: int, target: int = 0, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.drive.receive(0x200 + NODE, struct.pack("<Hi", word, target), self.now)
            self.sync()

    def sync(self) -> None:
        self.drive.synchronise(self.counts, 0.0, self.torque, self.now)
        self.run(PERIOD)

    def run(self, duration: float) -> None:
        for _ in range(round(duration / PERIOD)):
            for _ in range(round(PERIOD / DT)):
                self.drive.generator.step()
            self.now += PERIOD
            self.drive.update(self.counts, self.now)

    def enable(self) -> None:
        for word in (Controlword.SHUTDOWN, Controlword.SWITCH_ON, Controlword.ENABLE):
            self.cycle(word, self.counts)
        assert self.drive.state is PowerState.ENABLED

    def move(self, speed: float) -> None:
        """Move at a constant speed [rad/s]."""
        step = speed * INCREMENTS * PERIOD
        for k in range(1, 51):
            self.cycle(Controlword.ENABLE, round(k * step))


def test_a_slow_fault_reset_takes_its_time(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(), fault_reset=0.1)
    bench.drive.fail(0x2310)
    bench.cycle(Controlword.FAULT_RESET, cycles=49)
    assert bench.drive.state is PowerState.FAULT
    bench.cycle(Controlword.FAULT_RESET, cycles=2)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


def test_in_lockstep_sdo_requests_pass_time_for_a_reset(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(), fault_reset=0.1)
    bench.drive.fail(0x2310)
    bench.write(0x6040, "H", Controlword.FAULT_RESET)
    for _ in range(98):
        bench.read(0x6041)
    assert bench.drive.state is PowerState.FAULT
    for _ in range(3):
        bench.read(0x6041)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


def test_after_a_lost_master_only_reset_communication_makes_a_fault_resettable(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(), reset_after_heartbeat_loss=False, fault_on_heartbeat_loss=True)
    bench.write(0x1016, "I", 127 << 16 | 100, sub=1)
    bench.drive.receive(0x77F, b"\5", bench.now)
    bench.enable()
    bench.run(0.5)
    assert bench.drive.state is PowerState.FAULT
    assert bench.read(0x603F) == 0x8130
    bench.write(0x6040, "H", Controlword.FAULT_RESET)
    assert bench.drive.state is PowerState.FAULT
    bench.drive.receive(0x000, bytes([0x82, NODE]), bench.now)
    assert bench.drive.state is PowerState.FAULT
    for word in (Controlword.DISABLE_VOLTAGE, Controlword.FAULT_RESET):
        bench.write(0x6040, "H", word)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


def test_a_fault_may_be_there_from_the_start(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(), fault_at_power_on=0x3220)
    assert (0x80 + NODE, bytes.fromhex("2032010000000000")) in bench.sent
    assert bench.drive.state is PowerState.FAULT


def test_a_warning_is_no_fault(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base())
    bench.enable()
    bench.drive.warn(0x4210)
    assert bench.sent[-1] == (0x80 + NODE, bytes.fromhex("1042000000000000"))
    assert bench.drive.state is PowerState.ENABLED
    assert bench.drive.statusword & 0x80


def test_referenced_is_a_bit_of_the_statusword(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(modes=0x3A0), referenced_mask=0x8000, referenced=False)
    assert not bench.drive.statusword & 0x8000
    bench.write(0x6060, "b", 6)
    bench.enable()
    bench.cycle(Controlword.ENABLE | 0x10)
    assert bench.drive.statusword & 0x9400 == 0x9400


def test_enabling_takes_its_time(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base(), enabling=0.05)
    bench.cycle(Controlword.SHUTDOWN)
    bench.cycle(Controlword.SWITCH_ON)
    bench.cycle(Controlword.ENABLE, cycles=20)
    assert bench.drive.state is PowerState.SWITCHED_ON
    bench.cycle(Controlword.ENABLE, cycles=10)
    assert bench.drive.state is PowerState.ENABLED


@pytest.mark.parametrize(
    ("option", "afterwards"), [(2, PowerState.SWITCH_ON_DISABLED), (6, PowerState.QUICK_STOP), (0, None)]
)
def test_a_quick_stop_ends_as_its_option_says(option: int, afterwards: PowerState | None, tmp_path: Path) -> None:
    bench = Bench(tmp_path, base())
    bench.write(0x605A, "h", option)
    bench.enable()
    bench.move(1.0)
    bench.cycle(Controlword.QUICK_STOP)
    assert bench.drive.powered == (afterwards is not None)
    bench.run(1.0)
    assert bench.drive.state is (afterwards or PowerState.SWITCH_ON_DISABLED)


@pytest.mark.parametrize(
    ("items", "object_value"),
    [
        ({}, 10 * INCREMENTS),
        ({(0x60AA, 0): Item(U32, default=RPM_PER_SECOND)}, 10 * GEAR * 60 / (2 * 3.141592653589793)),
    ],
)
def test_a_quick_stop_has_the_deceleration_in_the_units_of_the_drive(
    items: dict[Any, Item], object_value: float, tmp_path: Path
) -> None:
    bench = Bench(tmp_path, base() | items)
    bench.write(0x6085, "I", round(object_value))
    bench.enable()
    bench.move(1.0)
    start = bench.drive.generator.position
    bench.cycle(Controlword.QUICK_STOP)
    bench.run(0.5)
    assert bench.drive.generator.position - start == pytest.approx(1.0 / (2 * 10), rel=0.05)


def test_without_605a_and_6085_a_quick_stop_is_as_hard_as_the_drive_can(tmp_path: Path) -> None:
    bench = Bench(tmp_path, {a: item for a, item in base().items() if a[0] not in (0x605A, 0x6085)})
    bench.enable()
    bench.move(1.0)
    bench.cycle(Controlword.QUICK_STOP)
    bench.run(0.01)
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


def test_positions_are_in_the_units_of_the_drive(tmp_path: Path) -> None:
    bench = Bench(tmp_path, MADE_UP["one_millisecond"].items)
    bench.enable()
    for _ in range(3):
        bench.cycle(Controlword.ENABLE, 90_000)  # a quarter of a turn of the motor, in units of 1/360,000 turn
    assert bench.counts == pytest.approx(INCREMENTS_PER_TURN / 4, abs=1)
    assert bench.read(0x6064, "i") == pytest.approx(90_000, abs=44)


def test_without_60c2_targets_are_interpolated_over_the_time_between_syncs(tmp_path: Path) -> None:
    bench = Bench(tmp_path, {a: item for a, item in base().items() if a[0] != 0x60C2})
    bench.enable()
    bench.drive.receive(0x200 + NODE, struct.pack("<Hi", Controlword.ENABLE, 1000), bench.now)
    bench.drive.synchronise(0, 0.0, 0.0, bench.now)
    for _ in range(5):
        bench.drive.generator.step()
    assert bench.counts == pytest.approx(500, abs=1)


def test_torque_and_current_are_per_mille_of_the_ratings(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base() | TORQUE | CURRENT)
    bench.torque = 0.952 * GEAR / 2
    bench.sync()
    assert (bench.read(0x6077, "h"), bench.read(0x6078, "h")) == (500, 500)


def test_ratings_that_the_file_does_not_give_are_those_of_the_motor(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base() | TORQUE | {(0x6076, 0): Item(U32, default=0)})
    assert bench.read(0x6076, "I") == round(1000 * Drive(node_id=1).rated_torque / GEAR)


def test_event_driven_tpdos_are_sent_on_a_change_from_power_up_on(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base() | four_tpdos())
    bench.run(0.1)
    ids = [arbitration_id for arbitration_id, _ in bench.sent]
    tpdos = [0x180 + NODE, 0x280 + NODE, 0x380 + NODE, 0x480 + NODE]
    assert [ids.count(tpdo) for tpdo in tpdos] == [1, 1, 1, 1]
    bench.sent.clear()
    bench.cycle(Controlword.SHUTDOWN)
    assert [arbitration_id for arbitration_id, _ in bench.sent] == tpdos[:3]


def test_event_timer_and_every_nth_sync(tmp_path: Path) -> None:
    items = base() | pdo(0, False, TPDO, kind=3) | pdo(1, False, TPDO, kind=255)
    bench = Bench(tmp_path, items | {(0x1801, 5): Item(U16, default=10)})
    bench.sent.clear()
    for _ in range(30):
        bench.sync()
    ids = [arbitration_id for arbitration_id, _ in bench.sent]
    assert (ids.count(0x180 + NODE), ids.count(0x280 + NODE)) == (10, pytest.approx(6, abs=1))


def test_bits_of_a_cob_id_that_a_drive_always_sets(tmp_path: Path) -> None:
    assert Bench(tmp_path, base(), cob_id_bits=0x4000_0000).read(0x1400, "I", sub=1) == 0x4000_0203


def test_guarding_is_answered_and_its_loss_noticed(tmp_path: Path) -> None:
    guarding = {(0x100C, 0): Item(U16, default=50), (0x100D, 0): Item(U8, default=2)}
    bench = Bench(tmp_path, base() | guarding)
    bench.write(0x6007, "h", 3)
    bench.enable()
    for expected in (0x05, 0x85, 0x05):
        bench.drive.receive_remote(0x700 + NODE, bench.now)
        assert bench.sent[-1] == (0x700 + NODE, bytes([expected]))
        bench.run(0.09)
    assert bench.drive.state is PowerState.ENABLED
    bench.run(0.3)
    assert (0x80 + NODE, bytes.fromhex("3081110000000000")) in bench.sent
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


def test_a_lost_rpdo_is_noticed_where_the_drive_has_a_timer(tmp_path: Path) -> None:
    bench = Bench(tmp_path, base() | {(0x1400, 5): Item(U16, default=20)})
    bench.write(0x6007, "h", 3)
    bench.enable()
    bench.run(0.3)
    assert (0x80 + NODE, bytes.fromhex("5082110000000000")) in bench.sent
    assert bench.drive.state is PowerState.SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    ("option", "state"),
    [
        (0, PowerState.ENABLED),
        (1, PowerState.FAULT),
        (2, PowerState.SWITCH_ON_DISABLED),
        (3, PowerState.SWITCH_ON_DISABLED),
    ],
)
def test_reactions_to_the_end_of_process_data(option: int, state: PowerState, tmp_path: Path) -> None:
    bench = Bench(tmp_path, base())
    bench.write(0x6007, "h", option)
    bench.enable()
    bench.drive.receive(0x000, bytes([0x80, NODE]), bench.now)
    bench.run(0.1)
    assert bench.drive.state is state


def test_settings_of_the_command_line_are_toml() -> None:
    habits = habits_from(["fault_reset = 0.1", 'allowed."605A"=[6]', 'refuse_write=["1006"]'], Habits(enabling=0.2))
    assert habits == Habits(fault_reset=0.1, allowed={"605A": (6,)}, refuse_write=("1006",), enabling=0.2)


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (["fault_reset"], "KEY=VALUE as in TOML"),
        (["slow=1"], "unknown key 'slow'"),
        (["fault_reset=-1"], "greater than or equal to 0"),
        (['refuse_read=["60C2.1"]'], "refuse_read.*pattern"),
        (['refuse_read=["XYZW"]'], "refuse_read"),
    ],
)
def test_settings_that_are_not_valid_are_explained(settings: list[str], reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        habits_from(settings, Habits())
