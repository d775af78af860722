import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.bus import Link
from drivers.canopen_drive import CanopenDrives, only_from_master
from drivers.protocol import Goal, Power
from recordings.errors import BadInput
from recordings.rig import Drive, Rig
from tests.drivers.scripted import Frame, ScriptedBus

RIG = Rig(
    name="test",
    drives=(
        Drive(node_id=1, counts_per_turn=1000, gear=math.tau),
        Drive(node_id=2, counts_per_turn=1000, gear=math.tau, sign=-1, zero_offset=0.5),
        Drive(node_id=3, counts_per_turn=1000, gear=math.tau),
    ),
)
"""1000 counts per radian; voltage 0.5 mV per count."""

SYNC = (0x080, "")
HEARTBEAT = (0x77F, "05")

# Statuswords as they stand on the wire.
DISABLED, READY, SWITCHED_ON, ENABLED, FAULT = "50 02", "31 02", "33 02", "37 12", "18 02"


def tpdo(node: int, status: str, counts: int = 0, volts: int = 0) -> Frame:
    body = counts.to_bytes(4, "little", signed=True) + volts.to_bytes(2, "little", signed=True)
    return 0x180 + node, f"{status} {body.hex(' ')}"


def rpdos(command: str, target: str = "00 00 00 00") -> list[tuple[Frame, list[Frame]]]:
    return [((0x200 + node, f"{command} {target}"), []) for node in (1, 2, 3)]


def answered(status: str) -> list[Frame]:
    return [tpdo(node, status) for node in (1, 2, 3)]


def drives(script: list[tuple[Frame, list[Frame]]]) -> tuple[CanopenDrives, ScriptedBus, list[tuple[str, str, str]]]:
    bus = ScriptedBus(script)
    log: list[tuple[str, str, str]] = []
    link = Link(bus, own_ids=lambda arbitration_id: False)
    return CanopenDrives(RIG, link, lambda *line: log.append(line)), bus, log


def test_enabling_goes_up_one_state_per_cycle() -> None:
    script = [
        *rpdos("00 00"),
        (HEARTBEAT, []),
        (SYNC, answered(DISABLED)),
        *rpdos("06 00"),
        (SYNC, answered(READY)),
        *rpdos("07 00"),
        (SYNC, answered(SWITCHED_ON)),
        *rpdos("0f 00"),
        (SYNC, answered(ENABLED)),
        *rpdos("0f 00"),
        (SYNC, answered(ENABLED)),
    ]
    amplifiers, bus, _ = drives(script)
    amplifiers.goal = Goal.ENABLED
    powers = [amplifiers.exchange(None, 0.01).power[0] for _ in range(5)]
    assert powers == [Power.OFF, Power.OFF, Power.OFF, Power.ON, Power.ON]
    bus.assert_finished()


@pytest.mark.parametrize(("goal", "command"), [(Goal.STOPPED, "02 00"), (Goal.DISABLED, "00 00")])
def test_way_down_is_one_command(goal: Goal, command: str) -> None:
    script = [
        *rpdos("00 00"),
        (HEARTBEAT, []),
        (SYNC, answered(ENABLED)),
        *rpdos(command),
        (SYNC, answered(DISABLED)),
    ]
    amplifiers, bus, _ = drives(script)
    amplifiers.exchange(None, 0.01)
    amplifiers.goal = goal
    assert amplifiers.exchange(None, 0.01).power == (Power.OFF,) * 3
    bus.assert_finished()


def test_units_signs_and_zero_offset() -> None:
    script = [
        ((0x201, "00 00 e8 03 00 00"), []),
        ((0x202, "00 00 f4 01 00 00"), []),
        ((0x203, "00 00 18 fc ff ff"), []),
        (HEARTBEAT, []),
        (SYNC, [tpdo(1, ENABLED, 250, 2000), tpdo(2, ENABLED, 250, 2000), tpdo(3, ENABLED, -250, -2000)]),
    ]
    amplifiers, _, _ = drives(script)
    (setpoint,) = amplifiers.encode(np.array([[1.0, 0.0, -1.0]]))
    sample = amplifiers.exchange(setpoint, 0.01)
    assert sample.position == pytest.approx((0.25, 0.25, -0.25))
    assert sample.voltage == pytest.approx((1.0, -1.0, -1.0))


def test_lost_answer_is_a_gap_and_an_answer_of_the_cycle_before_is_not_taken() -> None:
    script = [
        *rpdos("00 00"),
        (HEARTBEAT, []),
        (SYNC, [tpdo(1, ENABLED, 10), tpdo(3, ENABLED, 30)]),
        *(
            ((0x200 + node, f"00 00 {t}"), [])
            for node, t in ((1, "0a 00 00 00"), (2, "00 00 00 00"), (3, "1e 00 00 00"))
        ),
        (SYNC, [tpdo(1, ENABLED, 11), tpdo(2, ENABLED, 21), tpdo(3, ENABLED, 31)]),
    ]
    amplifiers, bus, _ = drives(script)
    first = amplifiers.exchange(None, 0.01)
    bus.receive_first(tpdo(2, ENABLED, 20))
    amplifiers.goal = Goal.DISABLED
    second = amplifiers.exchange(None, 0.01)
    assert first.missing == 1
    assert math.isnan(first.position[1])
    assert math.isnan(first.voltage[1])
    assert first.statusword[1] == 0
    assert second.missing == 0
    assert second.position[1] == pytest.approx(0.5 - 0.021)


def test_target_without_setpoint_is_where_the_drive_stands() -> None:
    script = [
        *rpdos("00 00"),
        (HEARTBEAT, []),
        (SYNC, [tpdo(1, DISABLED, 1000), tpdo(2, DISABLED, -2), tpdo(3, DISABLED, 0)]),
        ((0x201, "00 00 e8 03 00 00"), []),
        ((0x202, "00 00 fe ff ff ff"), []),
        ((0x203, "00 00 00 00 00 00"), []),
        (SYNC, answered(DISABLED)),
    ]
    amplifiers, bus, _ = drives(script)
    amplifiers.exchange(None, 0.01)
    amplifiers.exchange(None, 0.01)
    bus.assert_finished()


def test_fault_is_named_with_its_emergency_message() -> None:
    answers = [tpdo(1, ENABLED), (0x082, "11 86 21 00 00 00 00 00"), tpdo(2, FAULT), tpdo(3, ENABLED)]
    amplifiers, _, log = drives([*rpdos("00 00"), (HEARTBEAT, []), (SYNC, answers)])
    sample = amplifiers.exchange(None, 0.01)
    assert sample.trouble == "joint 2 (node 2): drive fault, following error (0x8611)"
    assert sample.error_code == (0, 0x8611, 0)
    assert log == [("error", "joint 2 (node 2)", "EMCY 0x8611: following error")]


def test_status_that_fits_no_state_is_not_taken_for_power_off() -> None:
    answers = [tpdo(1, "03 00"), tpdo(2, DISABLED), tpdo(3, DISABLED)]
    amplifiers, _, _ = drives([*rpdos("00 00"), (HEARTBEAT, []), (SYNC, answers)])
    assert amplifiers.exchange(None, 0.01).power[0] is Power.UNKNOWN


def test_target_beyond_32_bits_is_refused() -> None:
    amplifiers, _, _ = drives([])
    with pytest.raises(BadInput, match="32 bits"):
        amplifiers.encode(np.array([[0.0, 0.0, 1e7]]))


@given(st.lists(st.tuples(*[st.floats(-3, 3)] * 3), min_size=1, max_size=5))
def test_encoded_targets_read_back_within_half_a_count(targets: list[tuple[float, float, float]]) -> None:
    amplifiers, _, _ = drives([])
    for row, setpoint in zip(targets, amplifiers.encode(np.array(targets)), strict=True):
        for drive, angle, data in zip(RIG.drives, row, setpoint, strict=True):
            counts = int.from_bytes(data, "little", signed=True)
            assert drive.zero_offset + counts / drive.counts_per_radian == pytest.approx(angle, abs=0.51e-3)


@pytest.mark.parametrize("arbitration_id", [0x000, 0x080, 0x201, 0x603, 0x77F])
def test_master_frames(arbitration_id: int) -> None:
    assert only_from_master(arbitration_id)


@pytest.mark.parametrize("arbitration_id", [0x081, 0x181, 0x583, 0x701])
def test_drive_frames(arbitration_id: int) -> None:
    assert not only_from_master(arbitration_id)
