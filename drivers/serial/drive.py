"""The serial driver: drives with the ASCII protocol, on one line or on one line each.

There is no SYNC. A cycle is one exchange with every drive: the target is written, position and voltage are read. The
lines run in parallel, the drives of one line one after the other. Each cycle reads the status of one drive per
line, in turn.

Where a reply is lost or disturbed, the drive's answer to this cycle is missing; the line continues with the next
drive as soon as it is synchronized again, if there is time.

Limitation: the protocol does not let a drive detect the loss of the host. After SIGKILL, or with the cable pulled, a
drive completes its last move and then holds its position, with power on, unless the rig names a watchdog register.
The watchdog is armed before power is switched on and reset by every command. Drives without one, or without one
of its other protections, are refused unless the rig file accepts it by name.
"""

import time
from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from drivers.protocol import SIMULATED, CheckResult, Goal, Identity, Power, Report, Sample
from drivers.serial.axis import SerialAxis
from drivers.serial.line import SerialLine, converse
from drivers.serial.protocol import InvalidReply, LineError, LineLost, Reply, ReplyTimeout, Script
from drivers.serial.setup import protections
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig

SIMULATED_LOCKSTEP = f"{SIMULATED} in lockstep"

_ATTEMPTS = 3
"""Number of attempts for scripts outside the cycles; repeating them is harmless."""
_SETUP_TIMEOUT = 3.0
"""Time for the configuration of one drive [s]."""
_STOP_TIMEOUT = 1.0
"""Time that a drive may take to stop after the disable command [s]."""
_LAST_COMMANDS_TIMEOUT = 0.5
"""Time for the last commands on all lines [s]."""
_SETUP_PATIENCE = 0.2
"""Time that a reply may take before the cycles, where a busy host hurts nobody [s]."""

T = TypeVar("T")


class SerialDrives:
    """`drivers.protocol.Amplifiers` for the ASCII protocol on serial lines."""

    def __init__(self, rig: Rig, lines: dict[str, SerialLine], report: Report, *, stamped: bool) -> None:
        """`lines` by port; `stamped`: values have a time of measurement (not with simulated time)."""
        self.goal = Goal.DISABLED
        self._rig = rig
        self._report = report
        self._stamped = stamped
        self._axes = [SerialAxis(rig, joint) for joint in range(1, rig.dof + 1)]
        self._lines = {line: [axis for axis in self._axes if axis.port == port] for port, line in lines.items()}
        for line in lines.values():
            line.patience = _SETUP_PATIENCE
        self._status_turn = 0
        self._disturbances = 0
        self._configured = False

    # Before the cycles

    def discover(self) -> tuple[Identity, ...]:
        """See `Amplifiers`."""
        for line in self._lines:
            line.flush()
        identities, unanswered = [], []
        for axis in self._axes:
            try:
                identities.append(self._identity(axis))
            except LineError as error:
                unanswered.append(f"{axis.name}: {error}")
        if unanswered:
            raise RunFailed(
                f"{'; '.join(unanswered)}. Check supply, cable, baud rate and the ports, prefixes and registers in "
                "the rig file"
            )
        return tuple(identities)

    def _identity(self, axis: SerialAxis) -> Identity:
        device = self._run_script(axis, axis.identify)
        axis.lockstep = device == SIMULATED_LOCKSTEP
        return Identity(
            joint=axis.joint,
            address=axis.address,
            device=device,
            vendor_id=0,
            product_code=0,
            revision=None,
            simulated=device.startswith(SIMULATED),
            lockstep=axis.lockstep,
            position=self._run_script(axis, axis.read_position),
        )

    def check(self) -> Sequence[CheckResult]:
        """See `Amplifiers`."""
        return [*self._protections(), *(result for axis in self._axes for result in self._require(axis, axis.check))]

    def _protections(self) -> list[CheckResult]:
        return [
            CheckResult(axis.name, what, "protects", found, verdict)
            for axis in self._axes
            for what, found, verdict in protections(self._rig, axis.drive)
        ]

    def configure(self, *, decided: bool = False) -> None:
        """See `Amplifiers`."""
        accepted: dict[str, list[str]] = {}
        for row in self._protections():
            if row.verdict == "problem":
                raise BadInput(f"{row.where}: {row.what} {row.found}")
            if row.verdict == "accepted":
                accepted.setdefault(f"{row.what} {row.found}; the rig file accepts it", []).append(row.where)
        for text, places in accepted.items():
            self._report("warning", ", ".join(places), text)
        self._configured = True
        for axis in self._axes:
            self._require(axis, axis.configure)

    def _require(self, axis: SerialAxis, script: Callable[[], Generator[str, Reply, T]]) -> T:
        try:
            return self._run_script(axis, script)
        except LineError as error:
            raise RunFailed(f"{axis.name}: {error}") from None

    def _run_script(self, axis: SerialAxis, script: Callable[[], Generator[str, Reply, T]]) -> T:
        """Run a script with one drive; repeat it if the line was disturbed.

        Raises:
            LineError: the error of the last attempt.
            LineLost: the port is gone.
        """
        line = next(line for line, axes in self._lines.items() if axis in axes)
        result: list[T] = []

        def store() -> Script:
            result.append((yield from script()))

        for _ in range(_ATTEMPTS):
            failure = converse({line: store()}, time.perf_counter() + _SETUP_TIMEOUT).get(line)
            if not isinstance(failure, InvalidReply | ReplyTimeout):
                break
        if failure is not None:
            raise failure
        return result[0]

    # The cycle

    def encode(
        self, targets: NDArray[np.float64], torque: NDArray[np.float64] | None = None
    ) -> Sequence[list[list[str]]]:
        """See `Amplifiers`. Each target becomes the commands that write it."""
        rows = self._rig.target_counts(targets).tolist()
        offsets = self._rig.torque_offset_counts(np.zeros_like(targets) if torque is None else torque).tolist()
        return [
            [axis.target(count, offset) for axis, count, offset in zip(self._axes, row, extra, strict=True)]
            for row, extra in zip(rows, offsets, strict=True)
        ]

    def exchange(self, setpoint: list[list[str]] | None, timeout: float) -> Sample:
        """See `Amplifiers`. When a line is lost, the drives on the others are stopped before the error is raised;
        the next exchanges continue with them."""
        deadline = time.perf_counter() + timeout
        usable = self._usable_lines()
        for line in usable:
            line.patience = 0.0
        if not usable:
            raise RunFailed("all serial lines are lost")
        for axis in self._axes:
            axis.begin_cycle()
        failures = converse({line: self._cycle(line, setpoint) for line in usable}, deadline)
        self._status_turn += 1
        self._latch()
        for line, failure in failures.items():
            self._report_disturbance(line, failure)
        lost = [failure for failure in failures.values() if isinstance(failure, LineLost)]
        if lost:
            self._stop_other_lines()
            raise lost[0]
        return self._sample()

    def _latch(self) -> None:
        for line in self._usable_lines()[:1]:
            converse({line: self._lines[line][0].latch()}, time.perf_counter() + _SETUP_TIMEOUT)

    def _usable_lines(self) -> list[SerialLine]:
        return [line for line in self._lines if not line.lost]

    def _cycle(self, line: SerialLine, setpoint: list[list[str]] | None) -> Script:
        axes = self._lines[line]
        for i, axis in enumerate(axes):
            target = None if setpoint is None else setpoint[axis.joint - 1]
            try:
                yield from axis.cycle(self.goal, target, read_status=i == self._status_turn % len(axes))
            except (InvalidReply, ReplyTimeout) as disturbance:
                self._report_disturbance(line, disturbance)

    def _report_disturbance(self, line: SerialLine, failure: LineError | LineLost) -> None:
        # Only the first, second, fourth, eighth ...: a bad line would fill the log.
        self._disturbances += 1
        if self._disturbances & (self._disturbances - 1) == 0:
            self._report("warning", line.name, f"{failure} (disturbance {self._disturbances})")

    def _stop_other_lines(self) -> None:
        """Quick stop on the remaining lines."""
        self.goal = Goal.STOPPED
        converse(
            {line: self._all(line, SerialAxis.stop) for line in self._usable_lines()},
            time.perf_counter() + _LAST_COMMANDS_TIMEOUT,
        )

    def _all(self, line: SerialLine, script: Callable[[SerialAxis], Script]) -> Script:
        for axis in self._lines[line]:
            yield from script(axis)

    def _sample(self) -> Sample:
        axes = self._axes
        return Sample(
            position=tuple(axis.position for axis in axes),
            voltage=tuple(axis.voltage for axis in axes),
            statusword=tuple(axis.statusword for axis in axes),
            error_code=tuple(axis.fault & 0xFFFF for axis in axes),
            power=tuple(axis.power for axis in axes),
            missing=sum(not axis.answered for axis in axes),
            trouble=next((axis.trouble for axis in axes if axis.trouble), None),
            voltage_stamp=tuple(axis.voltage_stamp for axis in axes) if self._stamped else None,
            position_stamp=tuple(axis.position_stamp for axis in axes) if self._stamped else None,
        )

    # Shutdown

    def power_off(self) -> tuple[Power, ...]:
        """See `Amplifiers`: one drive after the other, each with the timeout of the configuration."""
        for axis in self._axes:
            axis.power = Power.UNKNOWN
        self._each("while switching power off", lambda axis: axis.switch_off(_STOP_TIMEOUT))
        return tuple(axis.power for axis in self._axes)

    def fault_details(self) -> str:
        """See `Amplifiers`: nothing, because the code of a fault comes with the answers."""
        return ""

    def close(self) -> None:
        """See `Amplifiers`: power off again, watchdog off, ports released."""
        if self._configured:
            self._each("while closing", SerialAxis.shut_down)
        for line in self._lines:
            line.close()

    def _each(self, when: str, script: Callable[[SerialAxis], Script]) -> None:
        for axis in self._axes:
            try:
                self._run_script(axis, partial(script, axis))
            except (LineError, RunFailed) as error:
                self._report("error", axis.name, f"{when}: {error}")
