import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.bus import Link
from drivers.canopen.discovery import is_master_frame
from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal, Power
from recordings.errors import BadInput
from recordings.rig import Drive, Rig
from tests.drivers.canopen.scripted import Frame, ScriptedBus

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

# Statuswords as transmitted.
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
    link = Link(bus)
    return CanopenDrives(RIG, link, lambda *line: log.append(line)), bus, log


def test_enabling_makes_one_transition_per_cycle() -> None:
    script = [
        *rpdos("00 00"),
        (HEARTBEAT, []),
        (SYNC, answered(DISABLED)),
        *rpdos("06 00"),
        (HEARTBEAT, []),  # until all are enabled: it arms their watchdogs
        (SYNC, answered(READY)),
        *rpdos("07 00"),
        (HEARTBEAT, []),
        (SYNC, answered(SWITCHED_ON)),
        *rpdos("0f 00"),
        (HEARTBEAT, []),
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
def test_stop_and_disable_take_one_controlword(goal: Goal, command: str) -> None:
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


def test_lost_answer_is_missing_and_a_late_answer_is_not_used() -> None:
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


def test_target_without_setpoint_is_the_measured_position() -> None:
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


def test_fault_is_reported_with_its_emcy_text() -> None:
    answers = [tpdo(1, ENABLED), (0x082, "11 86 21 00 00 00 00 00"), tpdo(2, FAULT), tpdo(3, ENABLED)]
    amplifiers, _, log = drives([*rpdos("00 00"), (HEARTBEAT, []), (SYNC, answers)])
    sample = amplifiers.exchange(None, 0.01)
    assert sample.trouble == "joint 2 (node 2): drive fault, following error (0x8611)"
    assert sample.error_code == (0, 0x8611, 0)
    assert log == [("error", "joint 2 (node 2)", "EMCY 0x8611: following error")]


def test_emcy_without_fault_ends_the_run_after_a_second_answer() -> None:
    alarm = (0x082, "10 43 09 00 00 00 00 00")
    answers = [tpdo(1, DISABLED), tpdo(2, DISABLED), tpdo(3, DISABLED)]
    amplifiers, _, _ = drives(_enabled(2, lambda k: [alarm, *answers] if k == 0 else answers))
    assert _exchanges(amplifiers, 2) == [None, "joint 2 (node 2): EMCY 0x4310: drive over-temperature"]


def test_emcy_that_is_reset_does_not_end_the_run() -> None:
    alarm, over = (0x082, "10 43 09 00 00 00 00 00"), (0x082, "00 00 00 00 00 00 00 00")
    answers = [tpdo(1, DISABLED), tpdo(2, DISABLED), tpdo(3, DISABLED)]
    amplifiers, _, _ = drives(_enabled(3, lambda k: [[alarm, *answers], [over, *answers], answers][k]))
    assert _exchanges(amplifiers, 3) == [None, None, None]


def test_invalid_statusword_means_unknown_power() -> None:
    answers = [tpdo(1, "03 00"), tpdo(2, DISABLED), tpdo(3, DISABLED)]
    amplifiers, _, _ = drives([*rpdos("00 00"), (HEARTBEAT, []), (SYNC, answers)])
    assert amplifiers.exchange(None, 0.01).power[0] is Power.UNKNOWN


def _exchanges(amplifiers: CanopenDrives, count: int) -> list[str | None]:
    return [amplifiers.exchange(None, 0.01).trouble for _ in range(count)]


def _enabled(cycles: int, answers: Callable[[int], list[Frame]]) -> list[tuple[Frame, list[Frame]]]:
    """Script of `cycles` cycles with controlword 0 and the given answers."""
    script: list[tuple[Frame, list[Frame]]] = []
    for k in range(cycles):
        script += rpdos("00 00")
        if k % 25 == 0:
            script.append((HEARTBEAT, []))
        script.append((SYNC, answers(k)))
    return script


def test_enabled_drive_that_ignores_its_target_ends_the_run_after_a_timeout() -> None:
    ignoring = "37 02"
    amplifiers, _, _ = drives(_enabled(60, lambda k: [tpdo(1, ENABLED), tpdo(2, ignoring), tpdo(3, ENABLED)]))
    troubles = _exchanges(amplifiers, 60)
    assert troubles[48] is None
    assert "joint 2 (node 2): enabled, but the target is not followed" in str(troubles[50])


def test_lost_heartbeat_ends_the_run() -> None:
    alive = [(0x700 + node, "05") for node in (1, 2, 3)]
    amplifiers, _, _ = drives(
        _enabled(
            400,
            lambda k: (alive if k == 0 else alive[1:]) + answered(DISABLED) if k % 50 == 0 else answered(DISABLED),
        )
    )
    troubles = _exchanges(amplifiers, 400)
    assert troubles[170] is None
    assert "joint 1 (node 1): heartbeat lost" in str(troubles[180])


def test_boot_up_message_before_the_cycle_is_no_heartbeat_that_could_be_lost() -> None:
    amplifiers, bus, _ = drives(_enabled(400, lambda k: answered(DISABLED)))
    bus.receive_first((0x701, "00"))
    assert set(_exchanges(amplifiers, 400)) == {None}


def test_restarted_drive_ends_the_run() -> None:
    amplifiers, _, log = drives(_enabled(1, lambda k: [(0x703, "00"), *answered(DISABLED)]))
    amplifiers._operational = True
    assert _exchanges(amplifiers, 1) == ["joint 3 (node 3): the drive restarted (boot-up message)"]
    assert log == [("error", "joint 3 (node 3)", "boot-up message: the drive restarted")]


def test_invalid_statusword_ends_the_run() -> None:
    amplifiers, _, _ = drives(_enabled(1, lambda k: [tpdo(1, DISABLED), tpdo(2, "03 00"), tpdo(3, DISABLED)]))
    assert _exchanges(amplifiers, 1) == ["joint 2 (node 2): statusword 0x0003 fits no state of CiA 402"]


def test_bus_off_ends_the_run_and_other_error_frames_are_reported_once() -> None:
    amplifiers, bus, log = drives(_enabled(2, lambda k: answered(DISABLED)))
    for _ in range(3):
        bus.receive_error(0x008, "00")
    assert _exchanges(amplifiers, 1) == [None]
    bus.receive_error(0x040, "00")
    assert _exchanges(amplifiers, 1) == ["bus-off: the CAN controller has switched itself off"]
    assert [level for level, _, _ in log] == ["warning", "error"]
    assert "protocol violation" in log[0][2]


def test_truncated_tpdo_counts_as_missing() -> None:
    amplifiers, _, _ = drives(_enabled(1, lambda k: [tpdo(1, DISABLED), (0x182, "50 02 00"), tpdo(3, DISABLED)]))
    assert amplifiers.exchange(None, 0.01).missing == 1


def test_emcy_text_of_the_rig_file_is_used() -> None:
    rig = RIG.model_copy(
        update={"drives": (*RIG.drives[:2], RIG.drives[2].model_copy(update={"emcy": {"FF01": "resistor hot"}}))}
    )
    bus = ScriptedBus(
        _enabled(
            1, lambda k: [(0x083, "01 ff 01 00 00 00 00 00"), tpdo(1, DISABLED), tpdo(2, DISABLED), tpdo(3, FAULT)]
        )
    )
    amplifiers = CanopenDrives(rig, Link(bus), lambda *line: None)
    assert amplifiers.exchange(None, 0.01).trouble == "joint 3 (node 3): drive fault, resistor hot (0xFF01)"


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
def test_frames_of_a_master(arbitration_id: int) -> None:
    assert is_master_frame(arbitration_id)


@pytest.mark.parametrize("arbitration_id", [0x081, 0x181, 0x583, 0x701])
def test_frames_of_a_drive(arbitration_id: int) -> None:
    assert not is_master_frame(arbitration_id)
