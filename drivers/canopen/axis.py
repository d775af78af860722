"""State of one CANopen drive, decoded from the frames it sends."""

import math
import struct
import time
from collections.abc import Callable

from drivers import cia402
from drivers.canopen import emcy, pdo, requirements
from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, integer_at, standard_dictionary
from drivers.canopen.presence import NO_PDOS, Presence
from drivers.canopen.sdo import Sdo, SdoWrite
from drivers.protocol import Power
from recordings.errors import RunFailed
from recordings.rig import Rig

_CONTROLWORD, _POSITION, _OFFSET = struct.Struct("<H"), struct.Struct("<i"), struct.Struct("<h")
STOP_TIMEOUT = 0.3
"""Time that a drive may take to stop when it is commanded by SDO [s]."""
_MODE_TIMEOUT = 0.5
"""Time that a drive may take to show the mode that was written [s]."""
_STILL_SPEED = 0.02
"""Joint speed below which a drive is at rest [rad/s]."""
_NO_MODE = 0
"""Object 6061 of drives that take over a mode only when they are enabled; whether they follow is supervised then."""


class CanopenAxis:
    """State of one drive. The raw values are the last ones received."""

    def __init__(self, rig: Rig, joint: int, link: Link, on_other_frame: Callable[[int, bytes], None]) -> None:
        """`joint`: 1 ... n; `on_other_frame`: see `Sdo`."""
        self.joint = joint
        self.drive = drive = rig.drives[joint - 1]
        self.name = f"joint {joint} ({drive.address})"
        self.sdo = Sdo(drive.node_id, self.name, link, on_other_frame, drive.axis)
        self._link = link
        self.counts: int | None = None
        self.statusword = 0
        self.state: cia402.DriveState | None = None
        self.last_code = 0
        """Code of the last EMCY, errors and warnings; 0: none, or reset."""
        self.error_code = 0
        """Code of the last EMCY that ends a run."""
        self.answers_since_emcy = 0
        """Number of answers since an EMCY that reported an error."""
        self.fault_without_emcy = False
        """Whether a fault ended the run before an EMCY told its code."""
        self.presence = Presence(drive.node_id)
        self.homing = self.homing_started = False
        """Whether the drive is in homing mode, and may search its zero."""
        self.answers_without_following = 0
        """Number of consecutive answers in which the drive was enabled but did not follow its target."""
        self.voltage_stamp = 0
        """Arrival of the last polled voltage [ns]; 0: none since the last answer."""
        self._effort_per_count = pdo.effort_per_count(rig, joint - 1)
        self.still_answers = 0
        """Number of consecutive answers in which the joint was at rest."""
        self._still_counts = max(1.0, _STILL_SPEED / rig.rate * abs(drive.counts_per_radian))
        self._raw = dict.fromkeys(("voltage", "torque"), math.nan)
        self.use(standard_dictionary(drive))
        self._received: set[int] = set()
        self.misfit = ""
        """The answer to this SYNC that had another length than the mapped one; one that is too short is missing."""

    def use(self, dictionary: DriveDictionary) -> None:
        """Set the drive's dictionary, which gives the sizes of what it sends.

        Raises:
            BadInput: a size cannot be mapped.
        """
        self.dictionary = dictionary
        voltage = self.drive.voltage
        self.voltage_size = len(dictionary.data.get((voltage.index, voltage.sub)) or bytes(2))
        """Size of the voltage object [bytes]."""
        self.tpdos = {tpdo.cob_id: tpdo for tpdo in pdo.tpdos(dictionary)}
        self.rpdos = {rpdo.cob_id: rpdo for rpdo in pdo.rpdos(dictionary)}
        # A drive that refuses 1017h keeps a shorter interval.
        self.presence.interval = min(dictionary.value((0x1017, 0)) or 0xFFFF, requirements.DRIVE_HEARTBEAT_MS) / 1000
        self.presence.guarded = dictionary.watchdog == "guarding"

    def target(self, counts: int, torque_offset: int = 0) -> bytes:
        """Bytes of a target, with a torque offset [thousandths] where the rig sends one."""
        return _POSITION.pack(counts) + (_OFFSET.pack(torque_offset) if self.drive.torque_offset else b"")

    def frames(self, controlword: int, target: bytes) -> list[tuple[int, bytes]]:
        """RPDOs of one cycle: arbitration ids and data."""
        data, frames = _CONTROLWORD.pack(controlword) + target, []
        for arbitration_id, rpdo in self.rpdos.items():
            frames.append((arbitration_id, data[: rpdo.layout.size]))
            data = data[rpdo.layout.size :]
        return frames

    def send_nmt(self, command: int) -> None:
        """Command a state of communication. Raises RunFailed where the bus does not accept it."""
        self._link.send(0x000, bytes([command, self.drive.node_id]))

    # By SDO

    def read_state(self) -> None:
        """Read the statusword.

        Raises:
            RunFailed: the drive does not answer.
        """
        self.statusword = self.sdo.read(0x6041, 0, "<H")
        self.decode_status()

    def command(self, controlword: int) -> None:
        """Write a controlword; raises as `read_state`."""
        self.sdo.write(SdoWrite(0x6040, 0, "<H", controlword, check=False))

    def stop_by(self, controlword: int) -> None:
        """Write a controlword; wait until the drive is off, for at most STOP_TIMEOUT. Raises as `read_state`."""
        self.state = None
        deadline = time.monotonic() + STOP_TIMEOUT
        self.command(controlword)
        self.read_state()
        while self.has_torque and time.monotonic() < deadline:
            self.read_state()

    def clear_torque_offset(self) -> None:
        """Write a torque offset of 0 where the rig sends one; raises as `read_state`."""
        if self.drive.torque_offset:
            self.sdo.write(SdoWrite(0x60B2, 0, "<h", 0, check=False))

    def confirm_mode(self, mode: int) -> bool:
        """Wait for a time until the drive shows the mode that was written (6061h); False where it shows none yet.

        Raises:
            RunFailed: it shows another one, or does not answer.
        """
        deadline = time.monotonic() + _MODE_TIMEOUT
        while (shown := self.sdo.read_optional(0x6061, 0, "<b")) not in (None, mode) and time.monotonic() < deadline:
            pass
        if shown not in (None, mode, _NO_MODE):
            raise RunFailed(
                f"{self.name}: mode {mode} was written, the drive shows mode {shown} (6061h); check what it supports"
            )
        return shown != _NO_MODE

    def is_homed(self) -> bool | None:
        """Whether the drive has its zero reference; None: it has no object that says it. Raises as `read_state`."""
        homed = self.drive.homed
        return None if homed is None else bool(integer_at(self.sdo, homed.index, homed.sub) & homed.mask)

    # One cycle

    def begin_cycle(self, now: float) -> None:
        """Discard the answer to the previous SYNC, at `now` [s]."""
        self.presence.begin_cycle(now, self.answered)
        self._received.clear()
        self.misfit = ""
        self._raw = dict.fromkeys(self._raw, math.nan)
        self.voltage_stamp = 0

    def take_tpdo(self, arbitration_id: int, data: bytes) -> bool:
        """Decode one TPDO; False where it is the second of this cycle."""
        if arbitration_id in self._received:
            return False
        self.presence.take_answer(arbitration_id, data)
        fields, layout = self.tpdos[arbitration_id].fields, self.tpdos[arbitration_id].layout
        if len(data) != layout.size:
            self.misfit = f"its TPDO (COB-ID {arbitration_id:03X}h) has {len(data)} bytes, {layout.size} are mapped"
            if len(data) < layout.size:
                return True
        values = dict(zip((field.name for field in fields), layout.unpack_from(data), strict=True))
        if "position" in values:
            before, self.counts = self.counts, values.pop("position")
            still = before is not None and abs(self.counts - before) <= self._still_counts
            self.still_answers = self.still_answers + 1 if still else 0
        if "status" in values:
            self.statusword = values.pop("status")
            self.decode_status()
            self.answers_since_emcy = self.answers_since_emcy + 1 if self.error_code else 0
        self._raw |= values
        self._received.add(arbitration_id)
        return True

    @property
    def answered(self) -> bool:
        """True when all TPDOs of this cycle have arrived."""
        return len(self._received) == len(self.tpdos)

    @property
    def is_limited(self) -> bool:
        """Whether the enabled drive says that a limit of its own holds it back."""
        return self.state is cia402.DriveState.ENABLED and bool(self.statusword & cia402.LIMIT_ACTIVE)

    @property
    def absence(self) -> str:
        """What is known of an answer that is missing; "": nothing."""
        if (state := NO_PDOS.get(self.presence.nmt_state)) and not self.misfit:
            heartbeat = f"COB-ID {0x700 + self.drive.node_id:03X}h"
            return f"its heartbeat ({heartbeat}) says that it is {state}, in which it sends no PDO"
        return self.misfit

    def take_polled_voltage(self, raw: int, stamp: int) -> None:
        """Store a voltage that was read by SDO and arrived at `stamp` [ns]."""
        self._raw["voltage"] = raw
        self.voltage_stamp = stamp

    def decode_status(self) -> None:
        """Decode power state and target following from the statusword."""
        self.state = cia402.decode(self.statusword)
        follows = self.homing or self.state is not cia402.DriveState.ENABLED
        follows = follows or not self.drive.target_followed_bit or bool(self.statusword & cia402.TARGET_FOLLOWED)
        self.answers_without_following = 0 if follows else self.answers_without_following + 1

    # In SI units

    @property
    def position(self) -> float:
        """Joint position [rad]; NaN where this cycle's answer is missing."""
        if not self.answered or self.counts is None:
            return math.nan
        return self.drive.to_position(self.counts)

    @property
    def voltage(self) -> float:
        """Signed operating voltage [V]; NaN where none arrived in this cycle."""
        return self._raw["voltage"] * self.drive.voltage.scale * self.drive.sign

    @property
    def effort(self) -> float:
        """Torque [N m] by torque actual or current actual; NaN where none arrived in this cycle."""
        return self._raw["torque"] * self._effort_per_count

    @property
    def power(self) -> Power:
        """Last known power state."""
        return Power.UNKNOWN if self.state is None else cia402.POWER[self.state]

    @property
    def has_torque(self) -> bool:
        """Whether the motor had torque in the last known state."""
        return self.power in (Power.ON, Power.STOPPING)

    # Errors

    def take_emcy(self, data: bytes) -> emcy.Emergency:
        """Store an EMCY message."""
        message = emcy.decode(data)
        self.last_code = message.code
        if message.ends_run:
            self.error_code = message.code
        elif not message.code:
            self.clear_errors()
        return message

    def text_of(self, code: int) -> str:
        """Words for an error code: those of the rig file, else of the standard."""
        return self.drive.emcy.get(f"{code:04X}", emcy.describe(code))

    def clear_errors(self) -> None:
        """Forget the errors that were reported."""
        self.last_code = self.error_code = self.answers_since_emcy = 0

    def trouble(self, cycle: int, heartbeat_timeout: int, following_timeout: int) -> str | None:
        """Reason to end the run in `cycle`, or None. `heartbeat_timeout`: cycles without a heartbeat or an answer to
        guarding; `following_timeout`: answers without following the target."""
        if self.presence.trouble:
            return f"{self.name}: {self.presence.trouble}"
        if self.state in (cia402.DriveState.FAULT, cia402.DriveState.FAULT_REACTION):
            if self.error_code:
                return f"{self.name}: drive fault, {self.text_of(self.error_code)} (0x{self.error_code:04X})"
            self.fault_without_emcy = True
            return f"{self.name}: drive fault without EMCY"
        if self.error_code and not self.answered:
            return f"{self.name}: no answer after {self.text_of(self.error_code)} (EMCY 0x{self.error_code:04X})"
        if self.answers_since_emcy > 1:
            # A fault in the statusword would be the better reason, and has had time to arrive.
            return f"{self.name}: EMCY 0x{self.error_code:04X}: {self.text_of(self.error_code)}"
        if self.answered and self.state is None:
            return f"{self.name}: statusword 0x{self.statusword:04X} fits no state of CiA 402"
        if self.is_limited and self.answers_without_following > 1:
            stops = "internal limit active (statusword bit 11), and the target is not followed"
            return f"{self.name}: {stops}; look for a limit switch, and at the limits of the drive"
        if self.answers_without_following >= following_timeout:
            return f"{self.name}: enabled, but the target is not followed (statusword bit 12); check its mode"
        heard = self.presence.last_heard
        if heard is not None and cycle - heard > heartbeat_timeout:
            lost = "no answer to node guarding" if self.presence.guarded else "heartbeat lost"
            return f"{self.name}: {lost}; check the cable and the drive's supply"
        return None
