"""One simulated CiA 402 drive on CANopen with any object dictionary: NMT, heartbeat both ways, EMCY, SDO, PDOs."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from canopen.emcy import EmcyProducer
from canopen.sdo import SdoAbortedError

from drivers.eds import Address, load_dictionary
from drivers.simulated.drive_state_machine import PowerState
from drivers.simulated.drive_units import UNIT_OBJECTS, encoder_resolution
from drivers.simulated.habits import Habits, Trouble, parse_address
from drivers.simulated.lss import REQUEST, LssSlave
from drivers.simulated.mark import EDS, marked
from drivers.simulated.master_watch import MasterWatch
from drivers.simulated.motion_control import FOLLOWING_ERROR, MotionControl
from drivers.simulated.node_axis import NodeAxis
from drivers.simulated.objects import INVALID_VALUE, Objects, Send
from drivers.simulated.process_data import ProcessData
from drivers.simulated.setpoint_generator import SetpointGenerator
from drivers.simulated.troubles import Due, Troubles
from recordings.rig import Drive

_BOOT_UP, _STOPPED, _OPERATIONAL, _PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
_NMT_STOP, _NMT_PRE_OPERATIONAL = 0x02, 0x80
_HEARTBEAT_LOST, _RPDO_LOST, _OVER_CURRENT, _SYNC_LOST = 0x8130, 0x8250, 0x2310, 0x8700
_WARNING = 0x80
"""Statusword bit 7."""
_MANUFACTURER = range(0x2000, 0x6000)
_OFF = 0x8000_0000
_COB_IDS = [(index, 1) for first in (0x1400, 0x1800) for index in range(first, first + 0x200)]
_SDO_TIME = 0.001
"""Time that an SDO request counts as in lockstep, where only SYNC moves the machine [s]."""
_DC_LINK = 48_000
"""Supply [mV]."""
_RATED_CURRENT = 5000
"""Of a motor whose drive does not say it [mA]."""


class SimulatedCanopenDrive:
    """One drive. `powered` and `generator` command the machine; `update` returns its state to the drive."""

    def __init__(
        self,
        drive: Drive,
        dt: float,
        send: Send,
        read_voltage: Callable[[], float],
        *,
        lockstep: bool,
        eds: Path = EDS,
        habits: Habits | None = None,
        axes: Sequence[int] = (1,),
        troubles: Sequence[Due] = (),
    ) -> None:
        """`drive`: encoder, gear and sign of the machine, where neither the dictionary nor `habits` say otherwise;
        `dt`: plant step [s]; `read_voltage` measures the motor voltage between two SYNCs [V]; `axes`: those of
        its node, the first one first; `troubles`: those that begin at an instant.

        Raises:
            BadInput: the EDS or DCF cannot be read.
        """
        self._habits = habits or Habits()
        self._axis = NodeAxis(drive.node_id, drive.axis, axes, send)
        self._send = send = self._axis.send
        self._lockstep = lockstep
        self._read_voltage = read_voltage
        dictionary = marked(load_dictionary(eds, drive.node_id), lockstep=lockstep)
        if not self._axis.is_first:
            # CiA 301 has no COB-IDs for the PDOs of further axes.
            off = {f"{index:04X}:{sub:X}": _OFF for index, sub in _COB_IDS}
            self._habits = self._habits.model_copy(update={"values": off | self._habits.values})
        self._objects = Objects(dictionary, self._habits, self._on_write, drive.node_id, send)
        self.drive = self._true_drive(drive)
        """Encoder and gear as they are."""
        self.lss = LssSlave(self._objects, send)
        self._emcy = EmcyProducer(0x80 + drive.node_id)
        self._emcy.network = self._objects.server.network
        self._process_data = ProcessData(self._objects, send, self._on_rpdo)
        self._watch = MasterWatch(self._objects)
        self._motion = MotionControl(self._objects, self.drive, self._habits, dt, self._on_fault_reset)
        self._objects.measured = self._measured_objects(drive)
        self._lost_count = 0
        """Increments by which the encoder is wrong."""
        self.troubles = Troubles(self._entries(), self._habits, troubles)
        self._boot(0.0)
        if self._habits.fault_at_power_on:
            self.fail(self._habits.fault_at_power_on)

    def _true_drive(self, drive: Drive) -> Drive:
        habits = self._habits
        counts = habits.counts_per_turn or encoder_resolution(self._objects) or drive.counts_per_turn
        return drive.model_copy(update={"counts_per_turn": counts, "gear": habits.gear or drive.gear})

    def _measured_objects(self, drive: Drive) -> dict[Address, Callable[[], int]]:
        motion = self._motion
        objects: dict[Address, Callable[[], int]] = {
            (0x1001, 0): lambda: int(self._error_code != 0),
            (0x603F, 0): lambda: self._error_code,
            (0x6041, 0): lambda: self.statusword,
            (0x6061, 0): lambda: motion.mode,
            (0x6063, 0): lambda: motion.counts,
            (0x6064, 0): lambda: round(motion.counts * motion.units.position),
            (0x606C, 0): lambda: round(motion.velocity * self._habits.velocity_factor),
            (0x6077, 0): self._torque_per_mille,
            # The current is proportional to the torque.
            (0x6078, 0): self._torque_per_mille,
            (0x6079, 0): lambda: _DC_LINK,
            (0x60F4, 0): lambda: round(motion.following_error),
        }
        voltage, scale = (drive.voltage.index, drive.voltage.sub), self._habits.voltage_scale or drive.voltage.scale
        if self._habits.voltage is not None:
            voltage = parse_address(self._habits.voltage)
        elif (own := self._axis.own(voltage[0]) or 0) in _MANUFACTURER:
            voltage = own, voltage[1]
        else:
            voltage = (0, 0)
        objects[voltage] = lambda: round(self.drive.sign * self._voltage / scale)
        if self._habits.cob_id_bits:
            objects |= {address: partial(self._cob_id, address) for address in _COB_IDS}
        return objects

    def _cob_id(self, address: Address) -> int:
        return self._objects.value(*address) | self._habits.cob_id_bits

    def _torque_per_mille(self) -> int:
        return max(-0x8000, min(round(self.drive.sign * self._torque / self._rated_torque * 1000), 0x7FFF))

    @property
    def _rated_torque(self) -> float:
        """Rated torque at the joint [N m]. Without 6076h the rig's own value: no digit is lost."""
        return self._objects.value(0x6076) / 1000 * self.drive.gear or self.drive.rated_torque

    def _boot(self, now: float, *, quietly: bool = False) -> None:
        self._objects.restore()
        self._set_ratings()
        self._error_code = 0
        self._warned = False
        self._voltage = self._torque = 0.0
        self._motion.restart(now)
        self._begin_communication(now, quietly=quietly)

    def _begin_communication(self, now: float, *, quietly: bool = False) -> None:
        self._nmt = _PRE_OPERATIONAL
        self._motion.reset_blocked = False
        self._process_data.restart()
        self._watch.restart()
        self._heartbeat_due = now
        if not quietly:
            self._send(0x700 + self.drive.node_id, bytes([_BOOT_UP]))

    def _set_ratings(self) -> None:
        """Give the motor's ratings, as a drive that was put into service has them, where the file gives none."""
        rated_torque = round(1000 * self.drive.rated_torque / self.drive.gear)
        for index, rating in ((0x6076, rated_torque), (0x6075, _RATED_CURRENT)):
            if not self._objects.value(index):
                self._objects.set(index, 0, rating)

    # Command to the machine, and what it became

    @property
    def powered(self) -> bool:
        """True while the position loop is closed."""
        return self._motion.powered

    @property
    def generator(self) -> SetpointGenerator:
        """Setpoints of the position loop."""
        return self._motion.generator

    @property
    def torque_offset(self) -> float:
        """Torque at the joint [N m] that 60B2h adds to the demand of the velocity controller."""
        return self.drive.sign * self._motion.torque_offset / 1000 * self._rated_torque

    @property
    def state(self) -> PowerState:
        """Power state."""
        return self._motion.state

    @property
    def statusword(self) -> int:
        """Object 6041."""
        return self._motion.statusword | (_WARNING if self._warned else 0)

    # Frames from the bus

    def receive(self, arbitration_id: int, data: bytes, now: float) -> None:
        """Process one data frame; SYNC is processed by `synchronise`."""
        self._motion.now = now
        node_id = self.drive.node_id
        if self._axis.is_off:
            return
        if arbitration_id == 0x000 and len(data) >= 2 and data[1] in (0, node_id):
            self._on_nmt(data[0], now)
        elif arbitration_id == REQUEST and len(data) == 8 and self._axis.is_first:
            self.lss.receive(data)
        elif arbitration_id == 0x600 + node_id and len(data) == 8:
            request = self._axis.request(data)
            if self._nmt != _STOPPED and request is not None:
                self._voltage = self._read_voltage()
                self._objects.server.on_request(arbitration_id, request, now)
                if self._lockstep:
                    self._motion.pass_time(_SDO_TIME)
        elif arbitration_id & 0x780 == 0x700:
            self._watch.hear(arbitration_id & 0x7F, now)
        elif self._nmt == _OPERATIONAL:
            self._process_data.receive(arbitration_id, data, now)

    def receive_remote(self, arbitration_id: int, now: float) -> None:
        """Process one remote frame: a guarding request."""
        if arbitration_id == 0x700 + self.drive.node_id and (0x100C, 0) in self._objects and not self._axis.is_off:
            self._send(arbitration_id, bytes([self._watch.guard(now) | self._nmt]))

    def synchronise(self, counts: int, voltage: float, torque: float, now: float | None = None) -> None:
        """Process SYNC at the time `now` [s], or the last known one: send the values measured now (encoder
        increments, V, N m), apply the target received before."""
        now = self._motion.now if now is None else now
        self._motion.counts, self._voltage, self._torque = counts + self._lost_count, voltage, torque
        self._motion.synchronise(now)
        if self._nmt != _OPERATIONAL or self._axis.is_off:
            return
        self._process_data.take_pending()
        self._motion.apply_controlword(self._objects.value(0x6040))
        self._process_data.answer_sync(now)
        self._motion.follow_target()

    def _on_nmt(self, command: int, now: float) -> None:
        if command == 0x81:
            self._boot(now)
            return
        before = self._nmt
        if command == 0x82:
            self._objects.restore(communication_only=True)
            self._begin_communication(now)
        else:
            self._nmt = {0x01: _OPERATIONAL, _NMT_STOP: _STOPPED, _NMT_PRE_OPERATIONAL: _PRE_OPERATIONAL}.get(
                command, before
            )
            if before != _OPERATIONAL == self._nmt:
                self._process_data.restart()
        if before == _OPERATIONAL != self._nmt:
            self._lose_connection()
            if command == _NMT_PRE_OPERATIONAL and not self.powered and not self._lost_count:
                self._lose_turns(self._habits.turns_off)

    def _on_rpdo(self, addresses: list[Address]) -> None:
        if (0x6040, 0) in addresses:
            self._motion.apply_controlword(self._objects.value(0x6040))

    def _on_write(self, address: Address, value: int) -> None:
        """Check a write by SDO, and act on it."""
        index = address[0]
        self._process_data.check_write(address, value, operational=self._nmt == _OPERATIONAL)
        self._watch.set_up(index)
        if index == 0x6060:
            self._check_mode(value)
        elif index in UNIT_OBJECTS:
            self._objects.set(*address, value)
            self._motion.units.refresh()
        elif index == 0x6040:
            self._motion.apply_controlword(value)

    def _check_mode(self, mode: int) -> None:
        supported = self._objects.value(0x6502)
        if mode > 0 and supported and not supported >> mode - 1 & 1:
            raise SdoAbortedError(INVALID_VALUE)

    # Faults

    def fail(self, code: int, *, silent: bool = False) -> None:
        """Enter a fault: EMCY unless `silent`, stop as object 605Eh says, then Fault."""
        if not self._motion.failed:
            self._error_code = code
            if not silent:
                self._emcy.send(code, 0x01)
            self._motion.enter_fault()

    def _entries(self) -> dict[Trouble, Callable[[], None]]:
        """What happens in each trouble."""
        motion = self._motion
        return {
            "short_tpdo": partial(self._process_data.resize, -1),
            "long_tpdo": partial(self._process_data.resize, 1),
            "nmt_stop": partial(self._obey, _NMT_STOP, heard=True),
            "pre_operational": partial(self._obey, _NMT_PRE_OPERATIONAL),
            "silent_fault": partial(self.fail, _OVER_CURRENT, silent=True),
            "sync_loss": partial(self.fail, _SYNC_LOST),
            "limit_switch": motion.reach_limit,
            "quick_stop": motion.quick_stop,
            "flicker": motion.flicker,
            "turn_lost": partial(self._lose_turns, 1),
            "quiet_reboot": lambda: self._boot(motion.now, quietly=True),
            "bus_off": self._axis.leave_bus,
        }

    def _obey(self, command: int, *, heard: bool = False) -> None:
        """Obey an NMT command that nobody sent or, where it is `heard`, another master."""
        if heard:
            self._send(0x000, bytes([command, self.drive.node_id]))
        self._on_nmt(command, self._motion.now)

    def _lose_turns(self, turns: int) -> None:
        """Let the encoder be wrong by turns of the motor from now on."""
        self._lost_count += self._motion.lose_turns(turns)

    def warn(self, code: int) -> None:
        """Send an EMCY that is no fault, and set the warning bit of the statusword."""
        self._warned = True
        self._emcy.send(code, 0x00)

    def _report(self, code: int, register: int) -> None:
        self._error_code = code
        self._emcy.send(code, register)

    def _on_fault_reset(self) -> None:
        self._error_code = 0
        self._emcy.reset()

    # Simulated time

    def update(self, counts: int, now: float) -> None:
        """Update encoder [increments] and clock [s] after the machine has moved: supervision, heartbeat, events."""
        if self._motion.update(counts + self._lost_count, now):
            self.fail(FOLLOWING_ERROR)
        self._watch_master(now)
        self.troubles.pass_time(now, powered=self.powered)
        if self._nmt == _OPERATIONAL:
            self._process_data.pass_time(now)
        interval = self._objects.value(0x1017) / 1000
        if interval and now >= self._heartbeat_due:
            self._heartbeat_due += interval
            self._send(0x700 + self.drive.node_id, bytes([self._nmt]))

    def _watch_master(self, now: float) -> None:
        if self._watch.is_lost(now):
            self._report(_HEARTBEAT_LOST, 0x11)
            self._motion.reset_blocked = not self._habits.reset_after_heartbeat_loss
            self._nmt = _PRE_OPERATIONAL
            self._lose_connection(is_fault=self._habits.fault_on_heartbeat_loss)
        elif self._nmt == _OPERATIONAL and self._process_data.lost_rpdo(now):
            self._report(_RPDO_LOST, 0x11)
            self._lose_connection()

    def _lose_connection(self, *, is_fault: bool = False) -> None:
        """Process the end of the process data as object 6007h says; without it nothing happens."""
        option = self._objects.value(0x6007)
        if is_fault or option == 1:
            if not self._motion.failed:
                self._error_code = self._error_code or _HEARTBEAT_LOST
                self._motion.enter_fault()
        elif self.state is PowerState.ENABLED and option == 2:
            self._motion.disable()
        elif self.state is PowerState.ENABLED and option == 3:
            self._motion.quick_stop()
