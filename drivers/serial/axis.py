"""One drive on a serial line: its commands in each situation, and its last known state."""

import math
import time
from collections.abc import Generator

from drivers import cia402
from drivers.protocol import CheckResult, Goal, Power, Verdict
from drivers.serial.protocol import CommandRefused, Reply, Script, ask, ask_integer, tell
from drivers.serial.setup import settings
from recordings.errors import RunFailed
from recordings.rig import Rig

_FAULTS = (
    "drive parameters damaged",
    "drive electronics",
    "short circuit",
    "drive too hot",
    "motor too hot",
    "supply voltage too high",
    "supply voltage too low",
    "encoder",
    "motor phasing",
    "following error",
    "current limited (I2T)",
    "drive program damaged",
    "command input lost",
)
"""Meaning of the fault register's bits, Copley-style, lowest first."""
COMMAND_LOST, FOLLOWING_ERROR = 1 << 12, 1 << 9
LATCH = "latch"
"""A command known only to drives simulated in lockstep."""

# The protocol has no statusword: the one of a CiA 402 drive in the same state is recorded.
_STATE = {
    Power.ON: cia402.DriveState.ENABLED,
    Power.OFF: cia402.DriveState.SWITCH_ON_DISABLED,
    Power.STOPPING: cia402.DriveState.QUICK_STOP,
    Power.FAULT: cia402.DriveState.FAULT,
}


class SerialAxis:
    """Commands and state of one drive. The raw values are the last ones received."""

    def __init__(self, rig: Rig, joint: int) -> None:
        """`joint`: 1 ... n."""
        self.joint = joint
        self.drive = rig.drives[joint - 1]
        self._rig, self._bus = rig, rig.serial
        shared = len(self._bus.ports) == 1
        node_prefix = f"{self.drive.node_id} " if shared else ""
        self.prefix = self._bus.prefixes[joint - 1] if self._bus.prefixes else node_prefix
        self.port = self._bus.ports[0 if shared else joint - 1]
        self.address = f"'{self.prefix.strip()}' on {self.port}" if self.prefix else self.port
        self.name = f"joint {joint} ({self.address})"
        self.power = Power.UNKNOWN
        self.counts: int | None = None
        self.raw_voltage = 0
        self.position_stamp = self.voltage_stamp = 0
        """When they were measured [ns]."""
        # The wall clock may be adjusted meanwhile.
        self._epoch = time.time_ns() - time.perf_counter_ns()
        self.fault = 0
        self.answered = False
        """Whether this cycle (between cycles: the last one) was answered."""
        self._answered_before = False
        self.trouble: str | None = None
        self.lockstep = False
        """Simulated, and its time advances only with a latch."""
        self.disable_acknowledged = False
        """Whether the drive has acknowledged the disable command since the last enable command."""
        self._stopping = False
        self._moving = False

    # Commands

    def get(self, register: str) -> str:
        """The command that reads a register."""
        return f"{self.prefix}g {register}"

    def set(self, register: str, value: int) -> str:
        """The command that writes a register."""
        return f"{self.prefix}s {register} {value}"

    def target(self, counts: int, torque_offset: int = 0) -> list[str]:
        """The commands that write a target, with a torque offset [thousandths] where the rig sends one."""
        offset = [self.set(self._bus.registers.torque_offset, torque_offset)] if self.drive.torque_offset else []
        return [*offset, self.set(self._bus.registers.position_command, counts)]

    # Before the cycles

    def identify(self) -> Generator[str, Reply, str]:
        """Subscript: the device name."""
        names = self._bus.registers
        text = yield from ask(self.get(names.device or names.status))
        return text if names.device else "serial drive"

    def read_position(self) -> Generator[str, Reply, float]:
        """Subscript: where the joint stands [rad or m]."""
        counts = yield from ask_integer(self.get(self._bus.registers.position))
        return self.drive.to_position(counts)

    def check(self) -> Generator[str, Reply, list[CheckResult]]:
        """Subscript: compare state and settings with the rig file."""
        yield from self._read_status()
        fault = f"fault: {self._fault_text()}" if self.power is Power.FAULT else ""
        state = fault or self.power.value
        results = [CheckResult(self.name, "state", "off", state, "will be written" if fault else "fine")]
        for setting in settings(self._rig, self.drive):
            actual = yield from ask_integer(self.get(setting.register))
            verdict: Verdict = "fine" if actual == setting.value else "will be written"
            what = f"{setting.register}: {setting.meaning}"
            results.append(CheckResult(self.name, what, str(setting.value), str(actual), verdict))
        return results

    def configure(self) -> Script:
        """Switch power off, clear faults, write the settings and read them back.

        Raises:
            RunFailed: a setting reads back as another value, or a fault remains.
        """
        yield from self._disable()
        yield from self._clear_faults()
        for setting in settings(self._rig, self.drive):
            yield from tell(self.set(setting.register, setting.value))
            actual = yield from ask_integer(self.get(setting.register))
            if actual != setting.value:
                raise RunFailed(
                    f"{self.name}: {setting.register} ({setting.meaning}) reads back as {actual}, {setting.value} "
                    "was written; check the register names and limits in the rig file"
                )
        yield from self._read_status()

    def _clear_faults(self) -> Script:
        register = self._bus.registers.fault
        if not register:
            return
        latched = yield from ask_integer(self.get(register))
        if latched:
            yield from tell(self.set(register, latched))
        self.fault = yield from ask_integer(self.get(register))
        if self.fault:
            raise RunFailed(f"{self.name}: {self._fault_text()}, cannot be reset; remove its cause at the drive")

    # One cycle

    def begin_cycle(self) -> None:
        """Mark the values of the previous cycle as old."""
        self._answered_before, self.answered = self.answered, False

    def cycle(self, goal: Goal, target: list[str] | None, read_status: bool) -> Script:
        """One exchange with this drive: the command for `goal`, the status if `read_status`, position, voltage.

        The command comes first, so that a disturbed reply does not prevent it.
        """
        try:
            yield from self._write_command(goal, target, read_status)
            if read_status:
                yield from self._read_status()
        except CommandRefused as refusal:
            yield from self._read_status()  # a fault is a better reason than the refused command
            self.trouble = self.trouble or f"{self.name}: {refusal}"
        names = self._bus.registers
        counts, self.position_stamp = yield from self._measure(names.position)
        self.raw_voltage, self.voltage_stamp = yield from self._measure(names.voltage)
        self.counts = counts
        self.answered = True

    def _measure(self, register: str) -> Generator[str, Reply, tuple[int, int]]:
        """Subscript: a value, and when it was measured [ns].

        The drive measures between the last character of the command and the first one of its reply. The middle of
        this interval is taken, so that delays of the host before and after count by half.
        """
        command = self.get(register)
        sent = time.perf_counter_ns()
        value = yield from ask_integer(command)
        latest = time.perf_counter_ns() - self._wire_time(f"v {value}")
        # The command may have waited for the line.
        earliest = max(sent + self._wire_time(command), latest - round(1e9 * self._bus.reply_timeout))
        return value, self._epoch + (earliest + latest) // 2

    def _wire_time(self, text: str) -> int:
        """Transmission time with the end character [ns]."""
        return round(1e9 * (len(text) + 1) * self._bus.character)

    def _write_command(self, goal: Goal, target: list[str] | None, status_turn: bool) -> Script:
        if goal is Goal.ENABLED:
            if self.power is Power.ON:
                yield from self._write_target(target)
            elif status_turn and self.power is Power.OFF and self._answered_before and self.counts is not None:
                yield from self._enable(self.counts)
        elif goal is Goal.STOPPED and not (self.disable_acknowledged or self._off or self._at_rest):
            yield from self.stop()
        elif not (self.disable_acknowledged and self._off):
            yield from self._disable()

    @property
    def _off(self) -> bool:
        return self.power in (Power.OFF, Power.FAULT)

    @property
    def _at_rest(self) -> bool:
        """Whether the status has shown the end of a quick stop."""
        return self._stopping and not self._moving

    def _write_target(self, target: list[str] | None) -> Script:
        if target is None:  # the drive holds its last target
            return
        for command in target:
            yield from tell(command)
        if self._bus.update:
            yield from tell(self.prefix + self._bus.update)

    def _enable(self, counts: int) -> Script:
        """Switch power on, with the measured position as target."""
        for command in self.target(counts):
            yield from tell(command)
        self.disable_acknowledged = self._stopping = False
        self.power = Power.UNKNOWN  # no longer off, until the status is read
        yield from tell(self.set(self._bus.registers.state, self._bus.enable))

    def stop(self) -> Script:
        """Quick stop, without torque offset."""
        try:
            yield from tell(self.prefix + self._bus.quick_stop)
            yield from self._clear_offset()
        except CommandRefused:
            yield from self._disable()
        self._stopping = self._moving = True  # until the status shows standstill

    def _disable(self) -> Script:
        yield from tell(self.set(self._bus.registers.state, self._bus.disable))
        self.disable_acknowledged = True
        yield from self._clear_offset()

    def _clear_offset(self) -> Script:
        if self.drive.torque_offset:
            yield from tell(self.set(self._bus.registers.torque_offset, 0))

    def switch_off(self, timeout: float) -> Script:
        """Switch power off and wait for it for at most `timeout` [s]."""
        deadline = time.perf_counter() + timeout
        yield from self._disable()
        yield from self._read_status()
        while not self._off and time.perf_counter() < deadline:
            yield from self.latch()
            yield from self._read_status()

    def latch(self) -> Script:
        """Let a period pass for drives simulated in lockstep, as SYNC does on CANopen."""
        if self.lockstep:
            yield from tell(self.prefix + LATCH)

    def shut_down(self) -> Script:
        """Switch power and watchdog off."""
        yield from self._disable()
        if self._bus.registers.watchdog:
            yield from tell(self.set(self._bus.registers.watchdog, 0))

    def _read_status(self) -> Script:
        """Update power, motion and fault from the status register."""
        names, bits = self._bus.registers, self._bus.status
        status = yield from ask_integer(self.get(names.status))
        self._moving = bool(status & bits.moving)
        if status & bits.fault:
            if names.fault:
                self.fault = yield from ask_integer(self.get(names.fault))
            self.power, self.trouble = Power.FAULT, f"{self.name}: drive fault, {self._fault_text()}"
        elif status & bits.off:
            self.power = Power.OFF
        else:
            self.power = Power.STOPPING if self._stopping else Power.ON

    def _fault_text(self) -> str:
        names = [text for bit, text in enumerate(_FAULTS) if self.fault >> bit & 1]
        return f"{', '.join(names) or 'no reason given'} (0x{self.fault:04X})"

    # In SI units

    @property
    def position(self) -> float:
        """Joint position [rad]; NaN if the last cycle was not answered."""
        if not self.answered or self.counts is None:
            return math.nan
        return self.drive.to_position(self.counts)

    @property
    def voltage(self) -> float:
        """Signed operating voltage [V]; NaN if the last cycle was not answered."""
        return self.raw_voltage * self.drive.voltage.scale * self.drive.sign if self.answered else math.nan

    @property
    def statusword(self) -> int:
        """CiA 402 statusword; 0 if the last cycle was not answered."""
        return cia402.STATUS_BITS[_STATE[self.power]] if self.answered and self.power in _STATE else 0
