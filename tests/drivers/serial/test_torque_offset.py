"""Torque offset on a serial line: a register, written before each target and 0 on every way out."""

import numpy as np
import pytest

from drivers.serial.axis import SerialAxis
from drivers.serial.protocol import Reply, Script
from drivers.transports import serial
from recordings.buses import SerialBus, SerialRegisters
from recordings.errors import BadInput
from recordings.rig import Rig
from tests.drivers.serial.script import DRIVES, RIG, drives

BUS = SerialBus(ports=("line",), registers=SerialRegisters(torque_offset="r0xd5"), baud=460_800)
WITH = Rig(name="r", rate=20.0, bus=BUS, drives=DRIVES).with_torque_offset()


def _commands(script: Script) -> list[str]:
    commands = [next(script)]
    try:
        while True:
            commands.append(script.send(Reply("ok")))
    except StopIteration:
        return commands


def test_offset_is_written_before_its_target_and_needs_a_register() -> None:
    (setpoint,) = drives([], WITH)[0].encode(np.zeros((1, 3)), np.array([[2.0, 2.0, 0.0]]))
    assert setpoint[:2] == [["1 s r0xd5 100", "1 s r0xca 0"], ["2 s r0xd5 -100", "2 s r0xca 500"]]
    (without,) = drives([], RIG)[0].encode(np.zeros((1, 3)))
    assert without[0] == ["1 s r0xca 0"]
    assert serial.cycle_time(WITH) > serial.cycle_time(Rig(name="r", rate=20.0, bus=BUS, drives=DRIVES))
    with pytest.raises(BadInput, match=r"joint 1: .*name it as torque_offset in \[bus.registers\]"):
        serial.check(RIG.with_torque_offset())


def test_offset_is_zero_at_power_on_and_on_every_way_out() -> None:
    axis = SerialAxis(WITH, 1)
    assert "1 s r0xd5 0" in _commands(axis._enable(7))[:-1]
    assert "1 s r0xd5 0" in _commands(axis.stop())
    assert "1 s r0xd5 0" in _commands(axis.shut_down())
    assert _commands(SerialAxis(RIG, 1).stop()) == ["1 t 0"]
