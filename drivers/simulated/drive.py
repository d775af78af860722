"""One simulated CiA 402 drive on CANopen: SDO server, NMT, heartbeat both ways, EMCY, PDOs on SYNC.

canopen's LocalNode serves the object dictionary; PDOs, NMT states, boot-up and watchdog are implemented here.
"""

from collections.abc import Callable

from canopen.sdo import SdoAbortedError

from drivers import cia402
from drivers.canopen.setup import MASTER_ID
from drivers.cia402 import DriveState
from drivers.simulated import drive_state_machine
from drivers.simulated.node import Send, local_node
from drivers.simulated.setpoint_generator import SetpointGenerator
from recordings.rig import Drive

_BOOT_UP, _STOPPED, _OPERATIONAL, _PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
_VOLTAGE_ENABLED, _REMOTE = 0x10, 0x200
_NOT_MAPPABLE, _WRONG_STATE = 0x06040041, 0x08000022
_PDO_MAPS = (0x1600, 0x1A00, 0x1A01)
_PDO_INVALID = 0x8000_0000
_INTERPOLATED_POSITION, _INTERPOLATE = 7, 0x10
_UNLIMITED = 2**32 - 1


class SimulatedCanopenDrive:
    """One drive. `powered` and `generator` command the machine; `update` returns its state to the drive."""

    def __init__(
        self, drive: Drive, dt: float, send: Send, read_voltage: Callable[[], int], *, lockstep: bool
    ) -> None:
        """`dt`: plant step [s]; `read_voltage` measures the motor voltage [counts] between two SYNCs."""
        self.drive = drive
        self.state = DriveState.SWITCH_ON_DISABLED
        self._send = send
        self._read_voltage = read_voltage
        self._lockstep = lockstep
        self.generator = SetpointGenerator(dt)
        self._boot(0.0)

    def _boot(self, now: float) -> None:
        self._node = local_node(self.drive.node_id, self._send)
        self._decoded: dict[tuple[int, int], int] = {}
        self._node.add_read_callback(self._on_read)
        self._node.add_write_callback(self._on_write)
        self._node.set_data(0x2F00, 1, bytes([self._lockstep]))
        self._nmt = _PRE_OPERATIONAL
        self._in_rpdo = False
        self._previous_controlword = 0
        self._error_code = 0
        self._counts = 0
        self._voltage = 0
        self._torque = 0
        self._last_master_heartbeat: float | None = None
        self._heartbeat_due = now
        self._following_error_since: float | None = None
        self._after_stop = DriveState.SWITCH_ON_DISABLED
        self._disable(DriveState.SWITCH_ON_DISABLED)
        self._send(0x700 + self.drive.node_id, bytes([_BOOT_UP]))

    # Command to the machine

    @property
    def powered(self) -> bool:
        """True while the position loop is closed."""
        return self.state in (DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.FAULT_REACTION)

    # Frames from the bus

    def receive(self, arbitration_id: int, data: bytes, now: float) -> None:
        """Process one frame; SYNC is processed by `synchronise`."""
        node_id = self.drive.node_id
        if arbitration_id == 0x000 and len(data) >= 2 and data[1] in (0, node_id):
            self._on_nmt(data[0], now)
        elif arbitration_id == 0x600 + node_id and len(data) == 8:
            if self._nmt != _STOPPED:
                self._voltage = self._read_voltage()
                self._node.sdo.on_request(arbitration_id, data, now)
        elif arbitration_id == 0x700 + MASTER_ID:
            self._last_master_heartbeat = now
        elif arbitration_id == self._object(0x1400, 1) and self._nmt == _OPERATIONAL:
            self._on_rpdo(data)

    def synchronise(self, counts: int, voltage: int, torque: float) -> None:
        """Process SYNC: send the values measured now (torque in N m), apply the target received before."""
        self._counts, self._voltage = counts, voltage
        self._torque = round(self.drive.sign * torque / self.drive.rated_torque * 1000)
        if self._nmt != _OPERATIONAL:
            return
        self._apply_controlword(self._object(0x6040))
        for number in (0, 1):
            cob_id = self._object(0x1800 + number, 1)
            if not cob_id & _PDO_INVALID:
                self._send(cob_id, self._pack_tpdo(0x1A00 + number))
        if self.state is DriveState.ENABLED and self._follows:
            counts = min(max(self._object(*self._target), self._object(0x607D, 1)), self._object(0x607D, 2))
            target = self.drive.to_position(counts)
            period = self._object(0x60C2, 1) * 10.0 ** self._object(0x60C2, 2)
            self.generator.interpolate(target, period)

    @property
    def _target(self) -> tuple[int, int]:
        return (0x60C1, 1) if self._object(0x6060) == _INTERPOLATED_POSITION else (0x607A, 0)

    @property
    def _follows(self) -> bool:
        """Whether the target is followed: in interpolated position mode the controlword must enable it."""
        return self._object(0x6060) != _INTERPOLATED_POSITION or bool(self._object(0x6040) & _INTERPOLATE)

    def _on_nmt(self, command: int, now: float) -> None:
        if command in (0x81, 0x82):
            self._boot(now)
        else:
            before = self._nmt
            self._nmt = {0x01: _OPERATIONAL, 0x02: _STOPPED, 0x80: _PRE_OPERATIONAL}.get(command, before)
            if before == _OPERATIONAL != self._nmt:
                self._lose_connection()

    def _on_rpdo(self, data: bytes) -> None:
        """Store the values; the controlword takes effect at the next SYNC."""
        self._in_rpdo = True
        offset = 0
        for index, sub, size in self._mapping(0x1600):
            field = data[offset : offset + size]
            if len(field) == size:
                self._node.set_data(index, sub, field)
            offset += size
        self._in_rpdo = False

    def _pack_tpdo(self, mapping: int) -> bytes:
        return b"".join(self._node.get_data(index, sub) for index, sub, _ in self._mapping(mapping))

    def _mapping(self, index: int) -> list[tuple[int, int, int]]:
        entries = (self._object(index, i + 1) for i in range(self._object(index, 0)))
        return [(entry >> 16, entry >> 8 & 0xFF, (entry & 0xFF) // 8) for entry in entries]

    # The object dictionary

    def _object(self, index: int, sub: int = 0) -> int:
        """Value of a stored object. Decoding takes microseconds, so the value is cached until the next write."""
        value = self._decoded.get((index, sub))
        if value is None:
            variable = self._node.object_dictionary.get_variable(index, sub)
            value = self._decoded[index, sub] = int(variable.decode_raw(self._node.get_data(index, sub)))
        return value

    def _on_read(self, index: int, subindex: int, **_: object) -> int | None:
        match index, subindex:
            case 0x603F, _:
                return self._error_code
            case 0x6041, _:
                return self.statusword
            case 0x6061, _:
                return self._object(0x6060)
            case 0x6064, _:
                return self._counts
            case 0x6077, _:
                return max(-0x8000, min(self._torque, 0x7FFF))
            case 0x2200, 1:
                return self._voltage
        return None

    def _on_write(self, index: int, subindex: int, data: bytes, **_: object) -> None:
        self._decoded.pop((index, subindex), None)
        if index in _PDO_MAPS:
            if self._nmt == _OPERATIONAL:
                raise SdoAbortedError(_WRONG_STATE)
            entry = int.from_bytes(data, "little")
            if subindex and entry:
                variable = self._node.object_dictionary.get_variable(entry >> 16, entry >> 8 & 0xFF)
                if variable is None or not variable.pdo_mappable or len(variable) != entry & 0xFF:
                    raise SdoAbortedError(_NOT_MAPPABLE)
        elif index == 0x1016:
            # The watchdog is armed by the first heartbeat after this write.
            self._last_master_heartbeat = None
        elif index == 0x6040 and not self._in_rpdo:
            self._apply_controlword(int.from_bytes(data, "little"))

    @property
    def statusword(self) -> int:
        """Object 6041."""
        word = cia402.STATUS_BITS[self.state] | _REMOTE
        if self.state is not DriveState.SWITCH_ON_DISABLED:
            word |= _VOLTAGE_ENABLED
        if self.state is DriveState.ENABLED and self._follows:
            word |= cia402.TARGET_FOLLOWED
        if self._following_error_since is not None:
            word |= cia402.FOLLOWING_ERROR
        return word

    # The power state machine

    def _apply_controlword(self, controlword: int) -> None:
        state = drive_state_machine.next_state(self.state, controlword, self._previous_controlword)
        self._previous_controlword = controlword
        if state is self.state:
            return
        if state is DriveState.ENABLED:
            # A target received before power-on must not move the axis.
            self.generator.hold(self.drive.to_position(self._counts))
        if state is DriveState.QUICK_STOP:
            self._begin_stop(DriveState.QUICK_STOP, DriveState.SWITCH_ON_DISABLED)
        elif self.state is DriveState.FAULT:
            self._error_code = 0
            self._node.emcy.reset()
            self._disable(state)
        elif self.powered:
            self._disable(state)
        else:
            self.state = state

    def _begin_stop(self, during: DriveState, afterwards: DriveState) -> None:
        self.state = during
        self._after_stop = afterwards
        self.generator.stop(self._object(0x6085) / abs(self.drive.counts_per_radian))

    def _disable(self, state: DriveState) -> None:
        self.state = state
        self.generator.hold(self.generator.position)

    def fail(self, code: int) -> None:
        """Enter a fault: EMCY, stop on the quick stop ramp (object 605E = 2), then Fault."""
        if self.state in (DriveState.FAULT, DriveState.FAULT_REACTION):
            return
        self._error_code = code
        self._node.emcy.send(code, 0x01)
        if self.powered:
            self._begin_stop(DriveState.FAULT_REACTION, DriveState.FAULT)
        else:
            self._disable(DriveState.FAULT)

    # Simulated time

    def update(self, counts: int, now: float) -> None:
        """Update encoder and clock [s] after the machine has moved: supervision, heartbeat, end of a stop."""
        self._counts = counts
        if self.state in (DriveState.QUICK_STOP, DriveState.FAULT_REACTION) and self.generator.at_rest:
            self._disable(self._after_stop)
        self._watch_following_error(now)
        self._watch_master(now)
        interval = self._object(0x1017) / 1000
        if interval and now >= self._heartbeat_due:
            self._heartbeat_due += interval
            self._send(0x700 + self.drive.node_id, bytes([self._nmt]))

    def _watch_following_error(self, now: float) -> None:
        window = self._object(0x6065)
        error = abs(self.generator.position - self.drive.to_position(self._counts)) * abs(
            self.drive.counts_per_radian
        )
        if not self.powered or window == _UNLIMITED or error <= window:
            self._following_error_since = None
            return
        if self._following_error_since is None:
            self._following_error_since = now
        if (now - self._following_error_since) * 1000 >= self._object(0x6066):
            self.fail(0x8611)

    def _watch_master(self, now: float) -> None:
        timeout = (self._object(0x1016, 1) & 0xFFFF) / 1000
        if not timeout or self._last_master_heartbeat is None or now - self._last_master_heartbeat <= timeout:
            return
        self._last_master_heartbeat = None
        self._error_code = 0x8130
        self._node.emcy.send(0x8130, 0x11)
        self._nmt = _PRE_OPERATIONAL
        self._lose_connection()

    def _lose_connection(self) -> None:
        """Process the end of the process data: object 6007 = 3 means quick stop."""
        if self.state is DriveState.ENABLED and self._object(0x6007) == 3:
            self._begin_stop(DriveState.QUICK_STOP, DriveState.SWITCH_ON_DISABLED)
