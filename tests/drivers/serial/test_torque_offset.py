"""Torque offset on a serial line: a register, written before each target and 0 on every way out."""

import numpy as np
import pytest

from drivers.protocol import Goal, Power
from drivers.transports import serial
from recordings.buses import SerialBus, SerialRegisters
from recordings.errors import BadInput
from recordings.rig import Rig
from tests.drivers.serial.script import DRIVES, MOVING, OFF, ON, RIG, cycle, drives, enable, off, run, status
from tests.drivers.serial.scripted_port import Exchange

BUS = SerialBus(ports=("line",), registers=SerialRegisters(torque_offset="r0xd5"), baud=460_800)
WITH = Rig(name="r", rate=20.0, bus=BUS, drives=DRIVES).with_torque_offset()


def test_offset_is_written_before_its_target_and_needs_a_register() -> None:
    (setpoint,) = drives([], WITH)[0].encode(np.zeros((1, 3)), np.array([[2.0, 2.0, 0.0]]))
    assert setpoint[:2] == [["1 s r0xd5 100", "1 s r0xca 0"], ["2 s r0xd5 -100", "2 s r0xca 500"]]
    (without,) = drives([], RIG)[0].encode(np.zeros((1, 3)))
    assert without[0] == ["1 s r0xca 0"]
    assert serial.cycle_time(WITH) > serial.cycle_time(Rig(name="r", rate=20.0, bus=BUS, drives=DRIVES))
    with pytest.raises(BadInput, match=r"joint 1: .*name it as torque_offset in \[bus.registers\]"):
        serial.check(RIG.with_torque_offset())


def test_offset_is_zero_at_power_on_and_on_every_way_out() -> None:
    zero: dict[int, Exchange] = {node: (f"{node} s r0xd5 0", "ok") for node in (1, 2, 3)}
    ways_out = {node: [off(node), zero[node]] for node in zero}
    script = [pair for first in zero for pair in cycle(first, {n: ways_out[n] for n in zero if n >= first})]
    script += [pair for node in zero for pair in cycle(node, {node: [zero[node], *enable(node)]}, word=ON)]
    script += cycle(1, {node: [(f"{node} t 0", "ok"), zero[node]] for node in zero}, word=MOVING)
    script += [pair for node in zero for pair in (*ways_out[node], status(node, OFF))]
    amplifiers, port, _ = drives(script, WITH)
    run(amplifiers, {Goal.DISABLED: 3, Goal.ENABLED: 3, Goal.STOPPED: 1})
    assert amplifiers.power_off() == (Power.OFF,) * 3
    port.assert_finished()
