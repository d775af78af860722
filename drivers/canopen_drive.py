"""The CANopen driver: CiA 402 drives in cyclic synchronous position, one RPDO and one TPDO per drive and SYNC.

Single-threaded: whoever calls also receives. Nothing is sent or read behind the caller's back, so the order of
frames is the order of calls.
"""

import math
import struct
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drivers import canopen_setup, cia402, emcy
from drivers.bus import Link
from drivers.protocol import Goal, Identity, Power, Report, Sample
from drivers.sdo import Sdo
from recordings.errors import BadInput, RunFailed
from recordings.rig import Drive, Rig

_TPDO = struct.Struct("<Hih")
_CONTROLWORD = struct.Struct("<H")
_SIMULATED_NAME = "delta-workbench simulated drive"
_PACE_OBJECT = 0x2F00


def only_from_master(arbitration_id: int) -> bool:
    """True for the frames that a CANopen master sends: NMT, SYNC, RPDO 1, SDO requests, its heartbeat."""
    function = arbitration_id & 0x780
    return arbitration_id in (0, 0x80, 0x700 + canopen_setup.MASTER_ID) or function in (0x200, 0x600)


class _Axis:
    """What is known of one drive."""

    def __init__(self, joint: int, drive: Drive, sdo: Sdo) -> None:
        self.name = f"joint {joint} (node {drive.node_id})"
        self.joint = joint
        self.drive = drive
        self.sdo = sdo
        self.scale = 1.0 / drive.counts_per_radian
        self.counts: int | None = None
        self.statusword = 0
        self.state: cia402.State | None = None
        self.error_code = 0
        self.error_text = ""

    @property
    def power(self) -> Power:
        return Power.UNKNOWN if self.state is None else cia402.POWER[self.state]


class CanopenDrives:
    """`drivers.protocol.Amplifiers` for CANopen."""

    def __init__(self, rig: Rig, link: Link, report: Report) -> None:
        self.goal = Goal.DISABLED
        self._rig = rig
        self._link = link
        self._report = report
        self._cycle = 0
        self._heartbeat_every = max(1, round(canopen_setup.MASTER_HEARTBEAT * rig.rate))
        self._operational = False
        self._axes = [
            _Axis(i + 1, drive, Sdo(drive.node_id, f"joint {i + 1} (node {drive.node_id})", link, self._dispatch))
            for i, drive in enumerate(rig.drives)
        ]
        self._handlers: dict[int, Callable[[bytes], None]] = {}
        for axis in self._axes:
            self._handlers[0x80 + axis.drive.node_id] = partial(self._on_emcy, axis)
            self._handlers[0x700 + axis.drive.node_id] = partial(self._on_heartbeat, axis)
        self._answers = {0x180 + axis.drive.node_id: axis for axis in self._axes}

    def discover(self) -> tuple[Identity, ...]:
        """See `Amplifiers`."""
        self._nmt(0x80)
        silent = [axis.name for axis in self._axes if not axis.sdo.answers()]
        if silent:
            raise RunFailed(
                f"no answer from {', '.join(silent)} on {self._rig.bus.interface} '{self._rig.bus.channel}'; check "
                "power, cable, termination, bit rate and the node ids in the rig file"
            )
        return tuple(self._identify(axis) for axis in self._axes)

    def _identify(self, axis: _Axis) -> Identity:
        profile = axis.sdo.read(0x1000, 0, "<I") & 0xFFFF
        if profile != 402:
            raise RunFailed(
                f"{axis.name}: a CiA 402 drive expected, device profile {profile} found; check the node id"
            )
        device = axis.sdo.read_text(0x1008)
        simulated = device == _SIMULATED_NAME
        return Identity(
            joint=axis.joint,
            address=f"node {axis.drive.node_id}",
            device=device,
            vendor_id=axis.sdo.read(0x1018, 1, "<I"),
            product_code=axis.sdo.read(0x1018, 2, "<I"),
            revision=axis.sdo.read(0x1018, 3, "<I"),
            simulated=simulated,
            lockstep=simulated and axis.sdo.read(_PACE_OBJECT, 1, "<B") == 1,
        )

    def configure(self) -> None:
        """See `Amplifiers`."""
        for axis in self._axes:
            for entry in canopen_setup.setup(self._rig, axis.drive):
                axis.sdo.write(entry.index, entry.sub, entry.layout, entry.value, check=entry.check)
            axis.counts = axis.sdo.read(0x6064, 0, "<i")
            self._read_state(axis)
            if axis.state is cia402.State.FAULT:
                self._reset_fault(axis)
        self._nmt(0x01)
        self._operational = True

    def _read_state(self, axis: _Axis) -> None:
        axis.statusword = axis.sdo.read(0x6041, 0, "<H")
        axis.state = self._decode(axis)

    def _reset_fault(self, axis: _Axis) -> None:
        # Fault reset acts on its rising edge only.
        for command in (cia402.Control.DISABLE_VOLTAGE, cia402.Control.FAULT_RESET, cia402.Control.DISABLE_VOLTAGE):
            axis.sdo.write(0x6040, 0, "<H", command, check=False)
        self._read_state(axis)
        if axis.state is cia402.State.FAULT:
            code = axis.sdo.read(0x603F, 0, "<H")
            raise RunFailed(f"{axis.name}: fault 0x{code:04X} cannot be reset; remove its cause at the drive first")
        axis.error_code, axis.error_text = 0, ""

    def encode(self, targets: NDArray[np.float64]) -> Sequence[list[bytes]]:
        """See `Amplifiers`. Each target becomes the four bytes of object 607A."""
        offsets = np.array([axis.drive.zero_offset for axis in self._axes])
        scales = np.array([axis.drive.counts_per_radian for axis in self._axes])
        counts = np.rint((targets - offsets) * scales)
        if not np.all(np.abs(counts) < 2**31):
            raise BadInput("a target lies outside the encoder's 32 bits; check counts_per_turn, gear and zero_offset")
        raw = np.ascontiguousarray(counts, dtype="<i4").tobytes()
        width = 4 * len(self._axes)
        return [
            [raw[row + 4 * j : row + 4 * j + 4] for j in range(len(self._axes))] for row in range(0, len(raw), width)
        ]

    def exchange(self, setpoint: list[bytes] | None, timeout: float) -> Sample:
        """See `Amplifiers`."""
        self._drain()
        link = self._link
        for j, axis in enumerate(self._axes):
            target = self._where_it_is(axis) if setpoint is None else setpoint[j]
            command = cia402.Control.DISABLE_VOLTAGE
            if axis.state is not None:
                command = cia402.controlword(self.goal, axis.state)
            link.send(0x200 + axis.drive.node_id, _CONTROLWORD.pack(command) + target)
        if self._cycle % self._heartbeat_every == 0:
            link.send(0x700 + canopen_setup.MASTER_ID, b"\x05")
        link.send(canopen_setup.SYNC_ID, b"")
        self._cycle += 1
        return self._collect(timeout)

    def _collect(self, timeout: float) -> Sample:
        deadline = time.perf_counter() + timeout
        voltage = dict.fromkeys(range(len(self._axes)), math.nan)
        answered: set[int] = set()
        while len(answered) < len(self._axes):
            frame = self._link.receive(max(0.0, deadline - time.perf_counter()))
            if frame is None:
                break
            axis = self._answers.get(frame[0])
            if axis is None or len(frame[1]) != _TPDO.size:
                self._dispatch(*frame)
                continue
            axis.statusword, axis.counts, raw = _TPDO.unpack(frame[1])
            axis.state = self._decode(axis)
            voltage[axis.joint - 1] = raw * axis.drive.voltage.scale * axis.drive.sign
            answered.add(axis.joint - 1)
        return self._sample(voltage, answered)

    def _sample(self, voltage: dict[int, float], answered: set[int]) -> Sample:
        axes = self._axes
        position = tuple(
            axis.drive.zero_offset + axis.counts * axis.scale
            if i in answered and axis.counts is not None
            else math.nan
            for i, axis in enumerate(axes)
        )
        return Sample(
            position=position,
            voltage=tuple(voltage.values()),
            statusword=tuple(axis.statusword if i in answered else 0 for i, axis in enumerate(axes)),
            error_code=tuple(axis.error_code for axis in axes),
            power=tuple(axis.power for axis in axes),
            missing=len(axes) - len(answered),
            trouble=next((text for axis in axes if (text := _trouble(axis))), None),
        )

    def _drain(self) -> None:
        """Take in what arrived since the last exchange; an answer that came too late must not pass for the next."""
        while (frame := self._link.receive(0.0)) is not None:
            self._dispatch(*frame)

    def _dispatch(self, arbitration_id: int, data: bytes) -> None:
        handler = self._handlers.get(arbitration_id)
        if handler is not None:
            handler(data)

    def _on_emcy(self, axis: _Axis, data: bytes) -> None:
        code, text = emcy.decode(data)
        axis.error_code, axis.error_text = code, text
        self._report("error" if code else "info", axis.name, f"EMCY 0x{code:04X}: {text}")

    def _on_heartbeat(self, axis: _Axis, data: bytes) -> None:
        if self._operational and data[:1] == b"\x00":
            axis.state = cia402.State.FAULT
            axis.error_text = "the drive restarted"
            self._report("error", axis.name, "boot-up message: the drive restarted")

    def _decode(self, axis: _Axis) -> cia402.State | None:
        try:
            return cia402.decode(axis.statusword)
        except ValueError:
            return None

    def _where_it_is(self, axis: _Axis) -> bytes:
        return struct.pack("<i", axis.counts or 0)

    def _nmt(self, command: int) -> None:
        for axis in self._axes:
            self._link.send(0x000, bytes([command, axis.drive.node_id]))

    def close(self) -> None:
        """See `Amplifiers`: Disable voltage once more by SDO, watchdog off, pre-operational."""
        if self._operational:
            for axis in self._axes:
                try:
                    axis.sdo.write(0x6040, 0, "<H", cia402.Control.DISABLE_VOLTAGE, check=False)
                    axis.sdo.write(0x1016, 1, "<I", 0)
                except RunFailed as error:
                    self._report("error", axis.name, f"while closing: {error}")
        try:
            self._nmt(0x80)
        except RunFailed as error:
            self._report("error", "bus", f"while closing: {error}")
        self._link.close()


def _trouble(axis: _Axis) -> str | None:
    if axis.state in (cia402.State.FAULT, cia402.State.FAULT_REACTION):
        return f"{axis.name}: drive fault, {axis.error_text or 'no EMCY received'} (0x{axis.error_code:04X})"
    return None
