"""Simulated amplifiers honour the torque offset as real ones: 60B2h in cyclic mode, a register on a serial line."""

import math
import struct

import pytest

from drivers.cia402 import Controlword
from drivers.simulated.serial_drive import SimulatedSerialDrive
from recordings.buses import SerialBus, SerialRegisters
from recordings.rig import Drive, Rig
from tests.drivers.simulated.test_drive import Bench


def _write(bench: Bench, offset: int) -> None:
    bench.sdo("2b b2 60 00" + struct.pack("<h", offset).hex(" ") + " 00 00")


def test_offset_acts_while_the_loops_are_closed() -> None:
    bench = Bench()
    _write(bench, 250)
    assert bench.drive.torque_offset == 0.0
    bench.enable()
    # A quarter of the rated torque of 20 N m at the joint.
    assert bench.drive.torque_offset == pytest.approx(5.0)
    bench.cycle(Controlword.QUICK_STOP)
    bench.run(0.5)
    bench.cycle(Controlword.DISABLE_VOLTAGE)
    assert bench.drive.torque_offset == 0.0


def test_offset_counts_in_the_direction_of_the_drive() -> None:
    bench = Bench()
    bench.drive.drive = bench.drive.drive.model_copy(update={"sign": -1})
    _write(bench, 100)
    bench.enable()
    assert bench.drive.torque_offset == pytest.approx(-2.0)


def test_register_of_a_serial_drive_acts_with_power() -> None:
    drives = (Drive(node_id=1, counts_per_turn=1000, gear=math.tau), Drive(node_id=2), Drive(node_id=3))
    bus = SerialBus(registers=SerialRegisters(torque_offset="r0xd5"))
    rig = Rig(name="r", rate=100.0, bus=bus, drives=drives)
    drive = SimulatedSerialDrive(rig, 1, 0.001, lambda: 0, lambda: 0, lockstep=True)
    assert [drive.handle(text, 0.0) for text in ("s r0xd5 -500", "g r0xd5")] == ["ok", "v -500"]
    assert drive.torque_offset == 0.0
    drive.handle("s r0x24 21", 0.0)
    assert drive.torque_offset == pytest.approx(-10.0)
