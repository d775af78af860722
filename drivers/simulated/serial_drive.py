"""One simulated drive with the ASCII protocol and the registers that the rig file names."""

import re
from collections.abc import Callable

from drivers.protocol import SIMULATED
from drivers.serial.axis import COMMAND_LOST, FOLLOWING_ERROR, SerialAxis
from drivers.serial.drive import SIMULATED_LOCKSTEP
from drivers.simulated.setpoint_generator import SetpointGenerator
from recordings.rig import Rig

_FOLLOWING_ERROR_TIME = 0.01
"""Duration of a following error after which it is a fault [s]."""
_SET = re.compile(r"s (\S+) (-?[0-9]{1,10})")
_GET = re.compile(r"g (\S+)")

UNKNOWN_COMMAND, UNKNOWN_REGISTER, OUT_OF_RANGE, READ_ONLY, WRONG_STATE = "e 3", "e 9", "e 10", "e 11", "e 14"


class SimulatedSerialDrive:
    """One drive. `powered` and `generator` command the machine; `update` returns its state to the drive."""

    def __init__(
        self,
        rig: Rig,
        joint: int,
        dt: float,
        position: Callable[[], int],
        voltage: Callable[[], int],
        *,
        lockstep: bool,
    ) -> None:
        """`joint`: 1 ... n; `dt`: plant step [s]; `position`, `voltage`: present values [counts]."""
        self.powered = False
        """Position loop closed."""
        self.generator = SetpointGenerator(dt)
        self.drive = rig.drives[joint - 1]
        axis = SerialAxis(rig, joint)
        self.prefix, self.port = axis.prefix, axis.port
        self._bus, self._names = rig.serial, rig.serial.registers
        self._period = 1.0 / rig.rate
        self._position = position
        self._device = SIMULATED_LOCKSTEP if lockstep else SIMULATED
        names = self._names
        writable = (
            *(names.position_command, names.state, names.fault, names.following_error, names.deceleration),
            *(names.upper_limit, names.lower_limit, names.watchdog, names.torque_offset, *self._bus.setup),
        )
        self._registers = {name: 0 for name in writable if name}
        self._registers[names.state] = self._bus.disable
        self._read_only: dict[str, Callable[[], str]] = {
            names.device: lambda: self._device,
            names.position: lambda: str(position()),
            names.voltage: lambda: str(voltage()),
            names.status: lambda: str(self.status),
        }
        self._stopping = False
        self._last_command = 0.0
        self._following_error_since: float | None = None

    @property
    def torque_offset(self) -> float:
        """Torque at the joint [N m] that the register adds to the demand of the loops."""
        share = self._value(self._names.torque_offset) / 1000 if self.powered else 0.0
        return self.drive.sign * share * self.drive.rated_torque

    @property
    def status(self) -> int:
        """The status register."""
        bits = self._bus.status
        faulty = bool(self._value(self._names.fault))
        moving = self.powered and not self.generator.at_rest
        return (bits.fault if faulty else 0) | (0 if self.powered else bits.off) | (bits.moving if moving else 0)

    def _value(self, register: str) -> int:
        return self._registers.get(register, 0)

    # Commands from the line

    def handle(self, command: str, now: float) -> str:
        """Reply to a command, both without prefix and end, that arrives at `now` [s]."""
        self._last_command = now
        if command == self._bus.quick_stop:
            if self.powered:
                self.generator.stop(self._deceleration)
            return "ok"
        if self._bus.update and command == self._bus.update:
            return self._follow()
        if match := _GET.fullmatch(command):
            return self._get(match[1])
        if match := _SET.fullmatch(command):
            return self._set(match[1], int(match[2]))
        return UNKNOWN_COMMAND

    def _get(self, register: str) -> str:
        if register in self._read_only:
            return f"v {self._read_only[register]()}"
        return f"v {self._registers[register]}" if register in self._registers else UNKNOWN_REGISTER

    def _set(self, register: str, value: int) -> str:
        if register in self._read_only:
            return READ_ONLY
        if register not in self._registers:
            return UNKNOWN_REGISTER
        if not -(2**31) <= value < 2**31:
            return OUT_OF_RANGE
        if register == self._names.fault:
            value = self._registers[register] & ~value
        self._registers[register] = value
        if register == self._names.state:
            return self._switch(value)
        if register == self._names.position_command and not self._bus.update and self.powered:
            return self._follow()
        return "ok"

    def _switch(self, state: int) -> str:
        enabling = state == self._bus.enable
        if enabling and self._value(self._names.fault):
            return WRONG_STATE
        if enabling and not self.powered:
            # A target received before power-on must not move the axis.
            self.generator.hold(self.drive.to_position(self._position()))
            self._stopping = False
            self.powered = True
        elif not enabling and self.powered:
            self._begin_stop()
        return "ok"

    def _follow(self) -> str:
        if not self.powered or self._stopping:
            return WRONG_STATE
        self.generator.interpolate(
            self.drive.to_position(self._registers[self._names.position_command]), self._period
        )
        return "ok"

    def _begin_stop(self) -> None:
        """Decelerate to rest, then switch power off."""
        self.generator.stop(self._deceleration)
        self._stopping = True

    @property
    def _deceleration(self) -> float:
        counts = max(1, self._value(self._names.deceleration)) * self._bus.deceleration_unit
        return counts / abs(self.drive.counts_per_radian)

    # Simulated time

    def update(self, now: float) -> None:
        """Update after the machine has moved, at `now` [s]: end of a stop, supervision."""
        if self._stopping and self.generator.at_rest:
            self.powered = self._stopping = False
        self._watch_following_error(now)
        timeout = self._value(self._names.watchdog) / 1000
        if timeout and self.powered and now - self._last_command > timeout:
            self.fail(COMMAND_LOST)

    def fail(self, fault: int) -> None:
        """Enter a fault: stop on the quick stop ramp, then power off."""
        if self._value(self._names.fault) & fault:
            return
        self._registers[self._names.fault] = self._value(self._names.fault) | fault
        if self.powered:
            self._begin_stop()

    def _watch_following_error(self, now: float) -> None:
        limit = self._value(self._names.following_error)
        error = abs(self.generator.position - self.drive.to_position(self._position())) * abs(
            self.drive.counts_per_radian
        )
        if not (self.powered and limit and error > limit):
            self._following_error_since = None
        elif self._following_error_since is None:
            self._following_error_since = now
        elif now - self._following_error_since >= _FOLLOWING_ERROR_TIME:
            self.fail(FOLLOWING_ERROR)
