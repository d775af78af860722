"""The CANopen driver: CiA 402 drives that follow position targets, with PDOs on SYNC.

Single-threaded: frames are sent and received only within calls, so the order of frames is the order of calls.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers import cia402
from drivers.canopen import check, discovery, pdo, preparation, readiness, requirements, self_test, shutdown
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.bus_monitor import BusMonitor
from drivers.canopen.dictionary import read_dictionary
from drivers.canopen.discovery import axes_by_node, names
from drivers.canopen.homing import DriveHoming
from drivers.canopen.kernel_sync import KernelSync
from drivers.canopen.poll import PolledVelocity, VoltagePoll, WatchedState
from drivers.protocol import CheckResult, Goal, Identity, Power, Report, Sample
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig

_INTERPOLATE = 0x10
"""Controlword bit 4 in interpolated position mode."""
_START_HOMING = 0x10
"""Controlword bit 4 in homing mode."""
_HEARTBEAT_TIMEOUT = 3.5 * requirements.DRIVE_HEARTBEAT_MS / 1000
"""Time without a heartbeat after which a drive counts as lost [s]."""
_STILL_TIME = 0.02
"""Time that a drive that stays in quick stop must be at rest before it is switched off [s]."""
_STAYS_IN_QUICK_STOP = (5, 6)
"""Quick stop options (605A) that end at rest, still powered."""
_FOLLOWING_TIMEOUT = 0.1
"""Time that an enabled drive may take to begin to follow its target [s]."""


class CanopenDrives:
    """`drivers.protocol.Amplifiers` for CANopen."""

    def __init__(self, rig: Rig, link: Link, report: Report, kernel_sync: KernelSync | None = None) -> None:
        """With `kernel_sync`, the kernel sends SYNC and `exchange` waits for it."""
        self.goal = Goal.DISABLED
        self._rig = rig
        self._link = link
        self._report = report
        self._kernel_sync = kernel_sync
        self._cycle = 0
        self._is_master = False
        """Whether no other master was heard; nothing may be sent before."""
        self._axes = [CanopenAxis(rig, joint, link, self._dispatch) for joint in range(1, rig.dof + 1)]
        polled = [axis for axis in self._axes if axis.drive.voltage.transfer == "sdo"]
        self._poll = VoltagePoll([axis for axis in polled if axis.drive.torque_source == "voltage"], link)
        for axis in self._axes:
            for watched in axis.drive.watched:
                state = WatchedState(axis, watched, report)
                self._poll.add(axis, (watched.index, watched.sub), state.take)
        self._monitor = BusMonitor(self._axes, link, rig, report)
        self._handlers: dict[int, Callable[[bytes], None]] = {}
        self._nodes = axes_by_node(self._axes)
        for node_id, axes in self._nodes.items():
            self._handlers[0x80 + node_id] = partial(self._on_emcy, axes)
            self._handlers[0x580 + node_id] = partial(self._poll.take_response, axes)
            self._handlers[0x700 + node_id] = partial(self._on_heartbeat, axes)
        self._listen_to_tpdos()
        if kernel_sync is not None:
            kernel_sync.on_sync = self._monitor.take_sync

    def _listen_to_tpdos(self) -> None:
        self._axis_of_tpdo = {arbitration_id: axis for axis in self._axes for arbitration_id in axis.tpdos}
        self._handlers |= self._monitor.handlers()

    # Before the cycle

    def discover(self) -> tuple[Identity, ...]:
        """See `Amplifiers`."""
        discovery.check_no_other_master(self._link)
        self._is_master = True
        self._send_nmt(0x80)
        discovery.check_one_drive_per_node(self._axes)
        return tuple(discovery.identify(axis) for axis in self._axes)

    def check(self) -> Sequence[CheckResult]:
        """See `Amplifiers`."""
        return [*check.unexpected_nodes(self._rig, self._link), *check.compare_with_rig(self._rig, self._axes)]

    def self_test(self, duration: float) -> Sequence[CheckResult]:
        """Run the cycle without power for `duration` [s], to see how well this host and the adapter keep time. Call
        after `configure`."""
        return list(self_test.self_test(self._rig, self._link, self.exchange, duration))

    def configure(self, *, decided: bool = False, referenced: bool = True) -> None:
        """See `Amplifiers`; `referenced`: refuse drives without their zero reference."""
        with preparation.said_once(self._report) as report:
            prepared = [preparation.Preparation(self._rig, axis, report, decided) for axis in self._axes]
            # Nothing else is written to any drive before all are off and known to fit.
            for drive in prepared:
                drive.switch_off()
            for drive in prepared:
                drive.check_fit()
            # Where the controlword does not help, the whole node is reset, with what was written to its other axes.
            for drive in prepared:
                drive.reset_fault()
            foreign = [size for drive in prepared for size in drive.set_up(referenced=referenced)]
            for axes in self._nodes.values():
                foreign += preparation.silence_other_axes(axes, report)
        self._listen_to_tpdos()
        self._check_load(foreign)
        self._send_nmt(0x01)
        self._monitor.armed = True

    def _check_load(self, foreign: list[int]) -> None:
        """Check the bus load with the sizes that the drives have, and with the PDOs that they did not let go of."""
        dictionaries, allowed = [axis.dictionary for axis in self._axes], self._rig.can.max_load
        load = pdo.bus_load(self._rig, self._rig.rate, dictionaries, foreign)
        if load > allowed:
            raise BadInput(
                f"with {len(foreign)} PDO(s) that are not ours the cycle takes up to {load:.0%} of the bus, "
                f"bus.max_load allows {allowed:.0%}; choose --rate {self._rig.rate * allowed / load:.0f} or less"
            )

    def encode(
        self, targets: NDArray[np.float64], torque: NDArray[np.float64] | None = None
    ) -> Sequence[list[bytes]]:
        """See `Amplifiers`. Each target becomes the four bytes of object 607A (or 60C1), and two of 60B2."""
        rated = [axis.dictionary.rated_torque for axis in self._axes]
        offsets = self._rig.torque_offset_counts(np.zeros_like(targets) if torque is None else torque, rated)
        rows = zip(self._rig.target_counts(targets).tolist(), offsets.tolist(), strict=True)
        return [[axis.target(*pair) for axis, *pair in zip(self._axes, *row, strict=True)] for row in rows]

    def poll_velocity(self, joint: int) -> PolledVelocity | None:
        """Poll 606Ch of `joint` (1 ... n) in the cycles to come; None where the drive does not state its unit (60A9h)
        or the bus has no room. Begin with `discover`."""
        axis = self._axes[joint - 1]
        unit = read_dictionary(axis.drive, axis.sdo).units.velocity
        if unit is None or pdo.bus_load(self._rig, self._rig.rate, foreign=(8, 8)) > self._rig.can.max_load:
            return None
        velocity = PolledVelocity(axis.drive.sign / unit.per_radian)
        self._poll.add(axis, (0x606C, 0), velocity.take)
        return velocity

    def in_doubt(self, joint: int) -> bool:
        """Whether the drive of `joint` (1 ... n) states two units of position, of which none is decided. Begin with
        `configure`."""
        return bool(readiness.position_doubt(self._axes[joint - 1].dictionary))

    # Homing

    def is_homed(self, joint: int) -> bool | None:
        """Whether the drive of `joint` (1 ... n) has its zero reference; None: it does not say."""
        return self._axes[joint - 1].is_homed()

    def homing(self, joint: int) -> DriveHoming:
        """One search of the zero of `joint` (1 ... n) by its drive. Begin with `configure`."""
        return DriveHoming(self._axes[joint - 1], self._rig.rate)

    # The cycle

    def exchange(self, setpoint: list[bytes] | None, timeout: float) -> Sample:
        """See `Amplifiers`."""
        deadline = time.perf_counter() + timeout
        for axis in self._axes:
            axis.begin_cycle(self._link.now() / 1e9)
        # Frames since the last exchange first, so that a late answer is not taken for the next one.
        for frame in self._link.frames(0.0):
            self._dispatch(*frame)
        self._poll.request(self._cycle)
        for j, axis in enumerate(self._axes):
            target = axis.target(axis.counts or 0) if setpoint is None else setpoint[j]
            for arbitration_id, data in axis.frames(self._controlword(axis), target):
                self._link.send(arbitration_id, data)
        # The first heartbeat that arrives arms a drive's watchdog, and one may be lost: sent until all are enabled.
        enabling = self.goal is Goal.ENABLED and any(axis.power is not Power.ON for axis in self._axes)
        if enabling or self._cycle % self._cycles(requirements.MASTER_HEARTBEAT) == 0:
            self._show_life()
        number = None
        if self._kernel_sync is None:
            self._link.send(requirements.SYNC_ID, b"")
            self._monitor.take_sync(foreign=False)
        else:
            number = self._kernel_sync.wait(self._dispatch, timeout)
            timeout = deadline - time.perf_counter()
        self._cycle += 1
        self._collect(timeout)
        self._monitor.end_cycle(self._cycle)
        return self._sample(number)

    def _show_life(self) -> None:
        self._link.send(0x700 + requirements.MASTER_ID, b"\x05")
        for node_id, axes in self._nodes.items():
            if axes[0].presence.guarded:
                self._link.send(0x700 + node_id, None)
                for axis in axes:
                    axis.presence.guard(self._cycle)

    def _controlword(self, axis: CanopenAxis) -> int:
        if self.goal is Goal.STOPPED and self._rests_in_quick_stop(axis):
            return cia402.Controlword.DISABLE_VOLTAGE
        command = cia402.next_controlword(self.goal, axis.state)
        if axis.homing:
            starts = axis.homing_started and command == cia402.Controlword.ENABLE
            return command | (_START_HOMING if starts else 0)
        if axis.drive.mode == "interpolated" and command == cia402.Controlword.ENABLE:
            return command | _INTERPOLATE
        return command

    def _rests_in_quick_stop(self, axis: CanopenAxis) -> bool:
        """Whether the drive has come to rest in a quick stop that it does not leave by itself."""
        resting = axis.still_answers >= self._cycles(_STILL_TIME) and axis.state is cia402.DriveState.QUICK_STOP
        return resting and axis.drive.quick_stop_option in _STAYS_IN_QUICK_STOP

    def _collect(self, timeout: float) -> None:
        for frame in self._link.frames(timeout):
            axis = self._axis_of_tpdo.get(frame[0])
            if axis is None or not axis.take_tpdo(*frame):
                self._dispatch(*frame)
            if all(axis.answered for axis in self._axes):
                break

    def _sample(self, sync: int | None) -> Sample:
        axes = self._axes
        return Sample(
            position=tuple(axis.position for axis in axes),
            voltage=tuple(axis.voltage for axis in axes),
            statusword=tuple(axis.statusword if axis.answered else 0 for axis in axes),
            error_code=tuple(axis.last_code for axis in axes),
            power=tuple(axis.power for axis in axes),
            missing=sum(not axis.answered for axis in axes),
            trouble=self._trouble(),
            effort=tuple(axis.effort for axis in axes) if pdo.measures_effort(self._rig) else None,
            voltage_stamp=tuple(axis.voltage_stamp for axis in axes) if self._poll.axes else None,
            sync=sync,
            absence=None if all(axis.answered for axis in axes) else tuple(axis.absence for axis in axes),
        )

    def _trouble(self) -> str | None:
        timeouts = self._cycles(_HEARTBEAT_TIMEOUT), self._cycles(_FOLLOWING_TIMEOUT)
        troubles = (axis.trouble(self._cycle, *timeouts) for axis in self._axes)
        return self._monitor.trouble or next(filter(None, troubles), None)

    # Unsolicited frames

    def _dispatch(self, arbitration_id: int, data: bytes) -> None:
        handler = self._handlers.get(arbitration_id)
        if handler is None:
            self._monitor.take_stray(arbitration_id)
        else:
            handler(data)

    def _on_emcy(self, axes: Sequence[CanopenAxis], data: bytes) -> None:
        """Store an EMCY, which does not say of which axis of its node it is."""
        *_, message = (axis.take_emcy(data) for axis in axes)
        axis, name = axes[0], names(axes)
        text = f"EMCY 0x{message.code:04X}: {axis.text_of(message.code)}"
        if message.ends_run or message.code == 0:
            self._report("error" if message.code else "info", name, text + message.details)
        else:
            self._monitor.say("warning", name, text, f"{message.details}; a warning, the run goes on")

    def _on_heartbeat(self, axes: Sequence[CanopenAxis], data: bytes) -> None:
        for axis in axes if data else ():
            axis.presence.hear(data, self._cycle, self._link.arrival / 1e9)

    # Shutdown

    def power_off(self) -> tuple[Power, ...]:
        """See `Amplifiers`: quick stop by SDO, then Disable voltage. Pre-operational nodes answer SDO as well."""
        try:
            self._send_nmt(0x80)
        except RunFailed as error:
            self._report("error", "bus", f"while switching power off: {error}")
        shutdown.power_off(self._axes, self._report)
        return tuple(axis.power for axis in self._axes)

    def fault_details(self) -> str:
        """See `Amplifiers`: by 603Fh or 1003h."""
        return "; ".join(shutdown.fault_details(axis) for axis in self._axes if axis.fault_without_emcy)

    def close(self) -> None:
        """See `Amplifiers`: Disable voltage again by SDO, watchdog off, pre-operational."""
        if self._kernel_sync is not None:
            self._kernel_sync.close()
        self._monitor.report_totals()
        try:
            if self._monitor.armed:
                shutdown.release(self._axes, self._report)
            if self._is_master:
                self._send_nmt(0x80)
        except RunFailed as error:
            self._report("error", "bus", f"while closing: {error}")
        self._link.close()

    def _send_nmt(self, command: int) -> None:
        for first, *_ in self._nodes.values():
            first.send_nmt(command)

    def _cycles(self, duration: float) -> int:
        return max(1, round(duration * self._rig.rate))
