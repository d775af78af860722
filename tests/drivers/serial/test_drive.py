"""The serial driver by (command, reply) pairs, with three drives on one line unless stated otherwise."""

import math

import numpy as np
import pytest

from drivers.protocol import Goal, Power
from drivers.serial.drive import SerialDrives
from recordings.buses import SerialBus
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig
from tests.drivers.serial.script import (
    DRIVES,
    FAULT,
    MOVING,
    OFF,
    ON,
    RELEASED,
    SET_UP,
    cycle,
    drives,
    enable,
    enabled,
    move,
    off,
    read,
    run,
    status,
)
from tests.drivers.serial.scripted_port import Exchange, ScriptedPort, line_on
from tests.simulated_time import SimulatedTime


def test_enable_is_repeated_at_the_last_measured_position_until_the_drive_is_on() -> None:
    script = [*RELEASED, *cycle(1, {1: enable(1, 0)}, counts=11), *cycle(2, {2: enable(2, 11)}, ON, counts=22)]
    script += [*cycle(3, {3: enable(3, 22)}, ON, counts=33), *cycle(1, {1: enable(1, 33)}, ON)]
    amplifiers, port, _ = drives(script)
    assert run(amplifiers, {Goal.DISABLED: 3, Goal.ENABLED: 4}).power == (Power.ON,) * 3
    port.assert_finished()


def test_power_is_unknown_without_a_reply_to_enable() -> None:
    amplifiers, _, _ = drives([*RELEASED, ("1 s r0xca 0", "ok"), ("1 s r0x24 21", ""), *read(2), *read(3)])
    assert run(amplifiers, {Goal.DISABLED: 3, Goal.ENABLED: 1}).power == (Power.UNKNOWN, Power.OFF, Power.OFF)


def test_no_power_on_with_an_old_position() -> None:
    """Without the last position there is no target for power-on."""
    lost: list[Exchange] = [status(1, OFF), ("1 g r0x32", ""), *read(2), *read(3)]
    wait = [*cycle(2, {2: enable(2)}), *cycle(3, {3: enable(3)}), *cycle(1, {1: enable(1)})]
    amplifiers, port, _ = drives([*RELEASED, *lost, *cycle(2), *cycle(3), *lost, *wait])
    run(amplifiers, {Goal.DISABLED: 7, Goal.ENABLED: 3})
    port.assert_finished()


def test_targets_are_written_and_updated_and_nothing_without_one() -> None:
    script = cycle(1, {1: move(1, 1000), 2: move(2, 500), 3: move(3, -1000)}, word=MOVING)
    amplifiers, port, _ = enabled([*script, *cycle(2, word=ON)])
    (setpoint,) = amplifiers.encode(np.array([[1.0, 0.0, -1.0]]))
    assert amplifiers.exchange(setpoint, 1.0).power == (Power.ON,) * 3
    amplifiers.exchange(None, 1.0)
    port.assert_finished()
    with pytest.raises(BadInput, match="32 bits"):
        amplifiers.encode(np.array([[1e7, 0.0, 0.0]]))


def test_units_signs_and_zero_offset() -> None:
    script = [off(1), status(1, OFF), *read(1, 250, 2000), off(2), *read(2, 250, 2000), off(3), *read(3, -250, -2000)]
    amplifiers, _, _ = drives(script)
    sample = amplifiers.exchange(None, 1.0)
    assert sample.position == pytest.approx((0.25, 0.25, -0.25))
    assert sample.voltage == pytest.approx((1.0, -1.0, -1.0))
    assert sample.power == (Power.OFF, Power.UNKNOWN, Power.UNKNOWN)
    assert sample.statusword == (0x40, 0, 0)
    assert sample.voltage_stamp is None


def quick_stops() -> dict[int, list[Exchange]]:
    return {node: [(f"{node} t 0", "ok")] for node in (1, 2, 3)}


def test_quick_stop_of_all_drives_then_power_off_of_each_at_rest() -> None:
    script = [
        *cycle(1, quick_stops(), word=MOVING),
        *cycle(2, quick_stops(), word=MOVING),
        *cycle(3, quick_stops(), word=ON),
        *cycle(1, {**quick_stops(), 3: [off(3)]}, word=ON),
        *cycle(2, {**quick_stops(), 1: [off(1)], 3: [off(3)]}, word=ON),
        *cycle(3, {node: [off(node)] for node in (1, 2, 3)}),
        *cycle(1, {node: [off(node)] for node in (1, 2)}),
        *cycle(2, {2: [off(2)]}),
        *cycle(3),
    ]
    amplifiers, port, _ = enabled(script)
    amplifiers.goal = Goal.STOPPED
    assert amplifiers.exchange(None, 1.0).power == (Power.STOPPING, Power.ON, Power.ON)
    for _ in range(8):
        sample = amplifiers.exchange(None, 1.0)
    assert sample.power == (Power.OFF,) * 3
    port.assert_finished()


def test_drive_that_refuses_the_quick_stop_is_switched_off() -> None:
    amplifiers, port, _ = enabled(cycle(1, {**quick_stops(), 2: [("2 t 0", "e 14"), off(2)]}, word=MOVING))
    run(amplifiers, {Goal.STOPPED: 1})
    port.assert_finished()


def test_disable_is_repeated_until_the_status_shows_off() -> None:
    amplifiers, port, _ = enabled(RELEASED)
    run(amplifiers, {Goal.DISABLED: 3})
    port.assert_finished()


def test_fault_ends_the_run() -> None:
    amplifiers, _, _ = enabled([status(1, FAULT), ("1 g r0xa4", "v 512"), *cycle(0)])
    sample = amplifiers.exchange(None, 1.0)
    assert sample.power[0] is Power.FAULT
    assert sample.error_code == (512, 0, 0)
    assert sample.statusword[0] & 0x4F == 0x08
    assert sample.trouble == "joint 1 ('1' on line): drive fault, following error (0x0200)"


@pytest.mark.parametrize(
    ("refused", "trouble"),
    [
        # A fault is the better reason for a refused command.
        ([status(2, FAULT), ("2 g r0xa4", "v 16")], "joint 2 ('2' on line): drive fault, motor too hot (0x0010)"),
        (
            [status(2, ON), *read(2)],
            "joint 2 ('2' on line): the drive refuses '2 t 1': not possible in the state of the axis (e 14)",
        ),
    ],
)
def test_refused_command_ends_the_run_with_the_best_reason(refused: list[Exchange], trouble: str) -> None:
    script = [*move(1, 0), status(1, ON), *read(1), ("2 s r0xca 500", "ok"), ("2 t 1", "e 14"), *refused]
    amplifiers, port, _ = enabled([*script, *(read(2) if len(refused) < 3 else []), *move(3, 0), *read(3)])
    assert amplifiers.exchange(amplifiers.encode(np.zeros((1, 3)))[0], 1.0).trouble == trouble
    port.assert_finished()


def test_remaining_drives_are_missing_without_time_for_them() -> None:
    script = [status(1, ON), *read(1, 1), ("2 g r0x32", ""), *cycle(2, word=ON)]
    amplifiers, port, log = enabled(script)
    assert amplifiers.exchange(None, 0.015).missing == 2
    assert len(log) == 1
    assert amplifiers.exchange(None, 1.0).missing == 0
    port.assert_finished()


@pytest.mark.parametrize(
    "reply", ["", "v", "ok", "v 1 2 3", b"\xff\xfe\r", b"v 1\rv 2\r", "e 33", b"v " + b"1" * 300]
)
def test_lost_or_invalid_reply_affects_only_its_drive_if_there_is_time_for_the_others(reply: str | bytes) -> None:
    script = [status(1, ON), *read(1, 1), ("2 g r0x32", reply), *read(3, 3), *cycle(2, word=ON)]
    amplifiers, port, log = enabled(script)
    sample = amplifiers.exchange(None, 1.0)
    assert np.isnan(sample.position).tolist() == [False, True, False]
    assert np.isnan(sample.voltage).tolist() == [False, True, False]
    assert sample.statusword == (0x27, 0, 0x27)
    assert sample.power == (Power.ON,) * 3
    assert sample.missing == len(log) == 1
    assert reply or log == [("warning", "port", "no reply in time (disturbance 1)")]
    assert amplifiers.exchange(None, 1.0).missing == 0
    port.assert_finished()


@pytest.mark.parametrize("goal", [Goal.STOPPED, Goal.DISABLED])
def test_stop_is_repeated_after_invalid_replies(goal: Goal) -> None:
    command = "t 0" if goal is Goal.STOPPED else "s r0x24 0"
    exchanges: list[Exchange] = [(f"1 {command}", "?"), (f"2 {command}", "?"), (f"3 {command}", "?")]
    amplifiers, port, _ = enabled(exchanges * 5)
    amplifiers.goal = goal
    for _ in range(5):
        assert amplifiers.exchange(None, 1.0).missing == 3
    port.assert_finished()


def test_disturbances_are_reported_ever_less_often() -> None:
    no_replies: list[Exchange] = [(f"{node} s r0x24 0", "") for node in (1, 2, 3)]
    amplifiers, _, log = drives(no_replies * 7)
    for _ in range(7):
        amplifiers.exchange(None, 1.0)
    assert [entry[2].split("disturbance ")[1] for entry in log] == ["1)", "2)", "4)", "8)", "16)"]


def test_close_switches_power_off_and_never_raises() -> None:
    script = [off(1), ("2 s r0x24 0", "e 14")]
    amplifiers, port, log = drives([*SET_UP, *script, *[("3 s r0x24 0", "")] * 3])
    amplifiers.configure()
    amplifiers.close()
    port.assert_finished()
    assert [(source[:7], text) for level, source, text in log if level == "error"] == [
        ("joint 2", "while closing: the drive refuses '2 s r0x24 0': not possible in the state of the axis (e 14)"),
        ("joint 3", "while closing: no reply in time"),
    ]


def test_power_off_waits_for_each_drive() -> None:
    script = [off(1), status(1, MOVING), status(1, OFF), *[("2 s r0x24 0", "")] * 3, off(3), status(3, FAULT)]
    amplifiers, port, log = drives([*script, ("3 g r0xa4", "v 4")])
    assert amplifiers.power_off() == (Power.OFF, Power.UNKNOWN, Power.FAULT)
    port.assert_finished()
    assert log == [("error", "joint 2 ('2' on line)", "while switching power off: no reply in time")]


# Three lines

THREE = Rig(name="test", rate=20.0, bus=SerialBus(ports=("a", "b", "c")), drives=DRIVES)


def on_three_lines(scripts: dict[str, list[Exchange]]) -> tuple[SerialDrives, dict[str, ScriptedPort]]:
    ports = {name: ScriptedPort(script) for name, script in scripts.items()}
    lines = {name: line_on(port, name) for name, port in ports.items()}
    return SerialDrives(THREE, lines, lambda *entry: None, stamped=True), ports


def alone(word: int, *commands: Exchange, counts: int = 0) -> list[Exchange]:
    """One cycle of a drive on its own line."""
    return [*commands, ("g r0xa0", f"v {word}"), ("g r0x32", f"v {counts}"), ("g r0x15", "v 1000")]


SWITCH_OFF: Exchange = ("s r0x24 0", "ok")
SWITCH_ON: list[Exchange] = [("s r0xca 0", "ok"), ("s r0x24 21", "ok")]


def test_drive_on_its_own_line_has_no_prefix_and_a_status_in_every_cycle(clock: SimulatedTime) -> None:
    amplifiers, ports = on_three_lines({name: alone(OFF, SWITCH_OFF, counts=i) for i, name in enumerate("abc")})
    sample = amplifiers.exchange(None, 1.0)
    assert sample.power == (Power.OFF,) * 3
    assert sample.position == pytest.approx((0.0, 0.499, 0.002))
    assert sample.voltage_stamp is not None
    assert sample.position_stamp is not None
    # The scripted port has no transmission time, which the stamps allow for.
    for stamp in (*sample.position_stamp, *sample.voltage_stamp):
        assert stamp == pytest.approx(clock.time_ns(), abs=2_000_000)
    for port in ports.values():
        port.assert_finished()


def test_other_lines_are_stopped_and_stay_usable_when_one_is_lost() -> None:
    start = [*alone(OFF, SWITCH_OFF), *alone(ON, *SWITCH_ON)]
    stopping = [*alone(ON), ("t 0", "ok"), *alone(ON, ("t 0", "ok")), *alone(OFF, SWITCH_OFF), *alone(OFF)]
    amplifiers, ports = on_three_lines({"a": start, "b": [*start, *stopping], "c": [*start, *stopping]})
    amplifiers.exchange(None, 1.0)
    amplifiers.goal = Goal.ENABLED
    amplifiers.exchange(None, 1.0)
    ports["a"].unplug()
    with pytest.raises(RunFailed, match=r"serial port a is lost \(unplugged\); check cable and adapter"):
        amplifiers.exchange(None, 1.0)
    for _ in range(3):
        sample = amplifiers.exchange(None, 1.0)
    assert sample.missing == 1
    assert math.isnan(sample.position[0])
    assert sample.power == (Power.ON, Power.OFF, Power.OFF)
    for name in "bc":
        ports[name].assert_finished()


def test_loss_of_all_lines_is_reported() -> None:
    amplifiers, ports = on_three_lines({"a": [], "b": [], "c": []})
    for port in ports.values():
        port.unplug()
    with pytest.raises(RunFailed, match="is lost"):
        amplifiers.exchange(None, 1.0)
    with pytest.raises(RunFailed, match="all serial lines are lost"):
        amplifiers.exchange(None, 1.0)
