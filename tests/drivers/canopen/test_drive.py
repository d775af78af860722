"""The CANopen driver in its cycles, frame by frame, with three drives."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal, Power, Sample
from recordings.errors import BadInput, RunFailed
from recordings.rig import Drive, Rig
from tests.drivers.canopen.scripted import Frame, ScriptedBus

RIG = Rig(
    name="test",
    drives=(
        Drive(node_id=1, counts_per_turn=1000, gear=math.tau),
        Drive(node_id=2, counts_per_turn=1000, gear=math.tau, sign=-1, zero_offset=0.5),
        Drive(node_id=3, counts_per_turn=1000, gear=math.tau, emcy={"FF01": "resistor hot"}),
    ),
)
"""1000 counts per radian; voltage 0.5 mV per count."""
HEARTBEAT = (0x77F, "05")

# Statuswords as transmitted.
DISABLED, READY, SWITCHED_ON, ENABLED, FAULT, IGNORING, INVALID = (
    *("50 02", "31 02", "33 02", "37 12", "18 02"),
    *("37 02", "03 00"),
)
Script = list[tuple[Frame, list[Frame]]]


def tpdo(node: int, status: str, counts: int = 0, volts: int = 0) -> Frame:
    body = counts.to_bytes(4, "little", signed=True) + volts.to_bytes(2, "little", signed=True)
    return 0x180 + node, f"{status} {body.hex(' ')}"


def answered(first: str, second: str = "", third: str = "") -> list[Frame]:
    """Answers of the three drives; the status of the first one where no other is given."""
    return [tpdo(1, first), tpdo(2, second or first), tpdo(3, third or first)]


def cycle(
    command: str, answers: list[Frame], *, heartbeat: bool = False, targets: tuple[int, int, int] = (0, 0, 0)
) -> Script:
    """What one cycle sends, with the answers to its SYNC."""
    rpdos = [
        ((0x201 + k, f"{command} {target.to_bytes(4, 'little', signed=True).hex(' ')}"), [])
        for k, target in enumerate(targets)
    ]
    return [*rpdos, *([(HEARTBEAT, [])] if heartbeat else []), ((0x080, ""), answers)]


def drives(script: Script) -> tuple[CanopenDrives, ScriptedBus, list[tuple[str, str, str]]]:
    bus, log = ScriptedBus(script), list[tuple[str, str, str]]()
    return CanopenDrives(RIG, Link(bus), lambda *line: log.append(line)), bus, log


def run(script: Script, goal: Goal = Goal.DISABLED) -> list[Sample]:
    """Samples of all cycles of a script."""
    amplifiers, bus, _ = drives(script)
    amplifiers.goal = goal
    samples = [amplifiers.exchange(None, 0.01) for _ in range(sum(frame == (0x080, "") for frame, _ in script))]
    bus.assert_finished()
    return samples


def test_enabling_makes_one_transition_per_cycle_and_shows_life_until_all_are_enabled() -> None:
    script = [
        *cycle("00 00", answered(DISABLED), heartbeat=True),
        *cycle("06 00", answered(READY), heartbeat=True),
        *cycle("07 00", answered(SWITCHED_ON), heartbeat=True),
        *cycle("0f 00", answered(ENABLED), heartbeat=True),
        *cycle("0f 00", answered(ENABLED)),
    ]
    powers = [sample.power[0] for sample in run(script, Goal.ENABLED)]
    assert powers == [Power.OFF, Power.OFF, Power.OFF, Power.ON, Power.ON]


@pytest.mark.parametrize(("goal", "command"), [(Goal.STOPPED, "02 00"), (Goal.DISABLED, "00 00")])
def test_stop_and_disable_take_one_controlword(goal: Goal, command: str) -> None:
    script = [*cycle("00 00", answered(ENABLED), heartbeat=True), *cycle(command, answered(DISABLED))]
    assert run(script, goal)[1].power == (Power.OFF,) * 3


def test_units_signs_and_zero_offset() -> None:
    answers = [tpdo(1, ENABLED, 250, 2000), tpdo(2, ENABLED, 250, 2000), tpdo(3, ENABLED, -250, -2000)]
    amplifiers, _, _ = drives(cycle("00 00", answers, heartbeat=True, targets=(1000, 500, -1000)))
    (setpoint,) = amplifiers.encode(np.array([[1.0, 0.0, -1.0]]))
    sample = amplifiers.exchange(setpoint, 0.01)
    assert sample.position == pytest.approx((0.25, 0.25, -0.25))
    assert sample.voltage == pytest.approx((1.0, -1.0, -1.0))
    with pytest.raises(BadInput, match="32 bits"):
        amplifiers.encode(np.array([[0.0, 0.0, 1e7]]))


@given(st.lists(st.tuples(*[st.floats(-3, 3)] * 3), min_size=1, max_size=5))
def test_encoded_targets_read_back_within_half_a_count(targets: list[tuple[float, float, float]]) -> None:
    amplifiers, _, _ = drives([])
    for row, setpoint in zip(targets, amplifiers.encode(np.array(targets)), strict=True):
        for drive, angle, data in zip(RIG.drives, row, setpoint, strict=True):
            counts = int.from_bytes(data, "little", signed=True)
            assert drive.zero_offset + counts / drive.counts_per_radian == pytest.approx(angle, abs=0.51e-3)


def test_lost_and_truncated_answers_are_missing_and_late_ones_not_used_and_measured_positions_are_held() -> None:
    later = [tpdo(1, ENABLED, 11), tpdo(2, ENABLED, 21), tpdo(3, ENABLED, 31)]
    script = [
        *cycle("00 00", [tpdo(1, ENABLED, 10), (0x182, "50 02 00"), tpdo(3, ENABLED, -30)], heartbeat=True),
        *cycle("00 00", later, targets=(10, 0, -30)),
    ]
    amplifiers, bus, _ = drives(script)
    first = amplifiers.exchange(None, 0.01)
    bus.receive_first(tpdo(2, ENABLED, 20))
    second = amplifiers.exchange(None, 0.01)
    assert first.missing == 1
    assert math.isnan(first.position[1])
    assert math.isnan(first.voltage[1])
    assert first.statusword[1] == 0
    assert second.missing == 0
    assert second.position[1] == pytest.approx(0.5 - 0.021)


# Reasons to end a run

ALARM, OVER = (0x082, "10 43 09 00 00 00 00 00"), (0x082, "00 00 00 00 00 00 00 00")
ALIVE = [(0x700 + node, "05") for node in (1, 2, 3)]


def _troubles(cycles: int, answers: Callable[[int], list[Frame]]) -> list[str | None]:
    script = [frame for k in range(cycles) for frame in cycle("00 00", answers(k), heartbeat=k % 25 == 0)]
    return [sample.trouble for sample in run(script)]


@pytest.mark.parametrize(
    ("answers", "troubles"),
    [
        (
            [[tpdo(1, ENABLED), (0x082, "11 86 21 00 00 00 00 00"), tpdo(2, FAULT), tpdo(3, ENABLED)]],
            ["joint 2 (node 2): drive fault, following error (0x8611)"],
        ),
        (
            [[(0x083, "01 ff 01 00 00 00 00 00"), *answered(DISABLED, third=FAULT)]],
            ["joint 3 (node 3): drive fault, resistor hot (0xFF01)"],
        ),
        # A fault in the statusword would be the better reason, and has time to arrive.
        (
            [[ALARM, *answered(DISABLED)], answered(DISABLED)],
            [None, "joint 2 (node 2): EMCY 0x4310: drive over-temperature"],
        ),
        (
            [[ALARM, tpdo(1, DISABLED), tpdo(3, DISABLED)]],
            ["joint 2 (node 2): no answer after drive over-temperature (EMCY 0x4310)"],
        ),
        ([[ALARM, *answered(DISABLED)], [OVER, *answered(DISABLED)], answered(DISABLED)], [None, None, None]),
        ([answered(DISABLED, INVALID)], ["joint 2 (node 2): statusword 0x0003 fits no state of CiA 402"]),
    ],
)
def test_reasons_that_the_drives_give(answers: list[list[Frame]], troubles: list[str | None]) -> None:
    assert _troubles(len(answers), lambda k: answers[k]) == troubles


def test_fault_is_reported_with_its_code_and_an_invalid_statusword_as_unknown_power() -> None:
    answers = [(0x082, "11 86 21 00 00 00 00 00"), *answered(INVALID, FAULT)]
    amplifiers, _, log = drives(cycle("00 00", answers, heartbeat=True))
    sample = amplifiers.exchange(None, 0.01)
    assert sample.error_code == (0, 0x8611, 0)
    assert sample.power == (Power.UNKNOWN, Power.FAULT, Power.UNKNOWN)
    assert log == [("error", "joint 2 (node 2)", "EMCY 0x8611: following error")]


def test_ignored_targets_and_lost_heartbeats_end_the_run_after_a_timeout_but_a_boot_up_is_no_heartbeat() -> None:
    ignored = _troubles(60, lambda k: answered(ENABLED, IGNORING))
    assert ignored[48] is None
    assert "joint 2 (node 2): enabled, but the target is not followed" in str(ignored[50])
    beats = {0: ALIVE} | dict.fromkeys(range(50, 400, 50), ALIVE[1:])
    lost = _troubles(400, lambda k: [*beats.get(k, []), *answered(DISABLED)])
    assert lost[170] is None
    assert "joint 1 (node 1): heartbeat lost" in str(lost[180])
    assert set(_troubles(400, lambda k: [*([(0x701, "00")] if k == 0 else []), *answered(DISABLED)])) == {None}


def test_restart_and_bus_off_end_the_run_and_other_error_frames_are_reported_once() -> None:
    quiet = cycle("00 00", answered(DISABLED))
    silent = cycle("00 00", answered(DISABLED)[:2])
    amplifiers, bus, log = drives([*cycle("00 00", answered(DISABLED), heartbeat=True), *silent, *quiet])
    for _ in range(3):
        bus.receive_error(0x008, "00")
    assert amplifiers.exchange(None, 0.01).trouble is None
    bus.receive_first((0x703, "00"))
    restarted = amplifiers.exchange(None, 0.01).trouble
    assert restarted == "joint 3 (node 3): the drive restarted (boot-up message)"
    bus.receive_error(0x040, "00")
    assert amplifiers.exchange(None, 0.01).trouble == "bus-off: the CAN controller has switched itself off"
    assert [(level, source) for level, source, _ in log] == [
        ("warning", "bus"),
        ("error", "bus"),
    ]
    assert "protocol violation" in log[0][2]


@pytest.mark.parametrize("arbitration_id", [0x000, 0x080, 0x201, 0x603, 0x77F])
def test_nothing_is_sent_beside_another_master_but_beside_other_drives(arbitration_id: int) -> None:
    amplifiers, bus, _ = drives([])
    bus.receive_first(*((drive, "") for drive in (0x081, 0x181, 0x583, 0x701)), (arbitration_id, ""))
    with pytest.raises(RunFailed, match=rf"another master is on this bus \(frame {arbitration_id:03X} seen\)"):
        amplifiers.discover()
    amplifiers.close()  # its drives stay as they are
