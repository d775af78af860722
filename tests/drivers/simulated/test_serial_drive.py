"""The simulated serial drive by (command, reply) pairs, without a machine."""

import math

import pytest

from drivers.serial.axis import COMMAND_LOST, FOLLOWING_ERROR
from drivers.simulated.serial_drive import SimulatedSerialDrive
from recordings.buses import SerialBus, SerialRegisters
from recordings.rig import Drive, Rig

DT = 0.001
OFF, MOVING, FAULT = 0x8000, 0x0800_2000, 0x0040_0000


class Bench:
    """A drive with its axis at `counts`; 1000 counts per radian."""

    def __init__(self, torque_offset: str = "", **bus: object) -> None:
        drive = Drive(node_id=1, counts_per_turn=1000, gear=math.tau)
        section = SerialBus(registers=SerialRegisters(watchdog="r0xf0", torque_offset=torque_offset), **bus)
        rig = Rig(name="r", rate=100.0, bus=section, drives=(drive, Drive(node_id=2), Drive(node_id=3)))
        self.counts, self.volts, self.time = 0, 0, 0.0
        self.drive = SimulatedSerialDrive(rig, 1, DT, lambda: self.counts, lambda: self.volts, lockstep=True)

    def say(self, *commands: str) -> list[str]:
        return [self.drive.handle(command, self.time) for command in commands]

    def run(self, duration: float, *, follow: bool = True) -> None:
        """Advance time by `duration` [s]; the axis follows the setpoint, or does not move."""
        for _ in range(round(duration / DT)):
            position = self.drive.generator.step()
            if follow:
                self.counts = round(1000 * position)
            self.time += DT
            self.drive.update(self.time)

    def enable(self) -> None:
        assert self.say("s r0xcf 1000", "s r0xba 50", "s r0x24 21") == ["ok", "ok", "ok"]


@pytest.mark.parametrize(
    ("command", "reply"),
    [
        ("x r0x32", "e 3"),
        ("s r0xca", "e 3"),
        ("s r0xca 1.5", "e 3"),
        ("g r0x99", "e 9"),
        ("s r0x99 1", "e 9"),
        ("s r0xca 3000000000", "e 10"),
        ("s r0x32 1", "e 11"),
        ("t 1", "e 14"),
    ],
)
def test_refused_commands(command: str, reply: str) -> None:
    assert Bench().say(command) == [reply]


def moving() -> Bench:
    """A drive that moves at 1 rad/s."""
    bench = Bench()
    bench.enable()
    for target in (10, 20, 30):
        bench.say(f"s r0xca {target}", "t 1")
        bench.run(0.01)
    bench.say("s r0xca 40", "t 1")
    bench.run(0.005)
    return bench


def test_quick_stop_decelerates_on_its_ramp_with_power_on() -> None:
    bench = moving()
    bench.say("t 0")
    bench.run(0.2)  # 1000 times 10 counts/s^2 are 10 rad/s^2: 0.1 s and 0.05 rad from 1 rad/s
    assert bench.say("g r0xa0") == ["v 0"]
    assert bench.drive.powered
    assert bench.counts == pytest.approx(35 + 50, abs=2)


def test_disable_stops_and_then_switches_power_off() -> None:
    bench = moving()
    bench.say("s r0x24 0")
    bench.run(0.05)
    assert bench.drive.powered
    assert bench.say("t 1") == ["e 14"]
    bench.run(0.1)
    assert not bench.drive.powered
    assert bench.say("g r0xa0") == [f"v {OFF}"]


def test_following_error_must_be_cleared_before_power_on() -> None:
    bench = Bench()
    bench.enable()
    bench.say("s r0xca 100", "t 1")
    bench.run(0.1, follow=False)
    assert bench.say("g r0xa4", "g r0xa0") == [f"v {FOLLOWING_ERROR}", f"v {FAULT | OFF}"]
    assert bench.say("s r0x24 21") == ["e 14"]
    assert bench.say(f"s r0xa4 {FOLLOWING_ERROR}", "s r0x24 21", "g r0xa0") == ["ok", "ok", "v 0"]


def test_only_a_watchdog_stops_the_drive_without_commands() -> None:
    bench = moving()
    bench.run(5.0)
    assert bench.drive.powered
    bench.say("s r0xf0 50")
    bench.run(0.04)
    bench.say("g r0x32")
    bench.run(0.04)
    assert bench.say("g r0xa4") == ["v 0"]
    bench.run(0.3)
    assert not bench.drive.powered
    assert bench.say("g r0xa4") == [f"v {COMMAND_LOST}"]


def test_torque_offset_acts_with_power() -> None:
    bench = Bench(torque_offset="r0xd5")
    assert bench.say("s r0xd5 -500", "g r0xd5") == ["ok", "v -500"]
    assert bench.drive.torque_offset == 0.0
    bench.enable()
    assert bench.drive.torque_offset == pytest.approx(-10.0)
