"""State of one CANopen drive, decoded from the frames it sends."""

import math
import struct
import time
from collections import Counter
from itertools import accumulate

from drivers import cia402
from drivers.canopen import emcy, pdo
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from drivers.canopen.sdo import Sdo, SdoWrite
from drivers.protocol import Power
from recordings.rig import Drive

_CONTROLWORD, _POSITION, _OFFSET = struct.Struct("<H"), struct.Struct("<i"), struct.Struct("<h")
STOP_TIMEOUT = 0.3
"""Time that a drive may take to stop when it is commanded by SDO [s]."""
_MODE_TIMEOUT = 0.5
"""Time that a drive may take to show the mode that was written [s]."""
_NO_PDOS = {0x04: "stopped", 0x7F: "pre-operational"}
"""States of communication in which a node sends no PDO, by its heartbeat."""
NO_MODE = 0
"""Object 6061 of drives that take over a mode only when they are enabled; whether they follow is supervised then."""


class CanopenAxis:
    """State of one drive. The raw values are the last ones received."""

    def __init__(
        self,
        joint: int,
        drive: Drive,
        sdo: Sdo,
        effort_per_count: float = math.nan,
        still_counts: float = 1.0,
    ) -> None:
        """`joint`: 1 ... n; `effort_per_count`: see `pdo.effort_per_count`; `still_counts`: largest change of the
        position from answer to answer that counts as rest."""
        self.name = f"joint {joint} (node {drive.node_id})"
        self.joint = joint
        self.drive = drive
        self.sdo = sdo
        self.counts: int | None = None
        self.statusword = 0
        self.state: cia402.DriveState | None = None
        self.last_code = 0
        """Code of the last EMCY, errors and warnings; 0: none, or reset."""
        self.error_code = 0
        """Code of the last EMCY that ends a run."""
        self.error_text = ""
        self.warnings: Counter[int] = Counter()
        """Number of EMCY of each code that do not end a run."""
        self.answers_since_emcy = 0
        """Number of answers since an EMCY that reported an error."""
        self.fault_without_emcy = False
        """Whether a fault ended the run before an EMCY told its code."""
        self.restarted = False
        self.nmt_state = 0
        """State of communication by the last heartbeat; 0: not known."""
        self.homing = self.homing_started = False
        """Whether the drive is in homing mode, and may search its zero."""
        self.last_heartbeat_cycle: int | None = None
        """Cycle in which the last heartbeat arrived."""
        self.answers_without_following = 0
        """Number of consecutive answers in which the drive was enabled but did not follow its target."""
        self.voltage_stamp = 0
        """Arrival of the last polled voltage [ns]; 0: none since the last answer."""
        self._effort_per_count = effort_per_count
        self.still_answers = 0
        """Number of consecutive answers in which the position changed by `still_counts` at most."""
        self._still_counts = still_counts
        self._raw = dict.fromkeys(("voltage", "torque"), math.nan)
        self.use(standard_dictionary(drive))
        self._received: set[int] = set()
        self._misfit = ""
        """The answer to this SYNC that had another length than the mapped one."""

    def use(self, dictionary: DriveDictionary) -> None:
        """Set the drive's dictionary, which gives the sizes of what it sends.

        Raises:
            BadInput: a size cannot be mapped.
        """
        self.dictionary = dictionary
        voltage = self.drive.voltage
        self.voltage_size = len(dictionary.data.get((voltage.index, voltage.sub)) or bytes(2))
        """Size of the voltage object [bytes]."""
        self._layout = {
            pdo.tpdo_id(self.drive, number): (
                number,
                fields,
                struct.Struct("<" + "".join(f.layout for f in fields)),
            )
            for number, fields in pdo.tpdos(self.drive, dictionary).items()
        }

        received = pdo.rpdos(self.drive, dictionary)
        ends = list(accumulate(sum(map(pdo.size_of, mapped)) for mapped in received.values()))
        ids = [pdo.rpdo_id(self.drive, number) for number in received]
        self._parts = list(zip(ids, [0, *ends], ends, strict=False))

    def target(self, counts: int, torque_offset: int = 0) -> bytes:
        """Bytes of a target, with a torque offset [thousandths] where the rig sends one."""
        return _POSITION.pack(counts) + (_OFFSET.pack(torque_offset) if self.drive.torque_offset else b"")

    def frames(self, controlword: int, target: bytes) -> list[tuple[int, bytes]]:
        """RPDOs of one cycle: arbitration ids and data."""
        data = _CONTROLWORD.pack(controlword) + target
        return [(arbitration_id, data[begin:end]) for arbitration_id, begin, end in self._parts]

    @property
    def answer_ids(self) -> tuple[int, ...]:
        """Arbitration ids of the drive's TPDOs."""
        return tuple(self._layout)

    @property
    def command_ids(self) -> tuple[int, ...]:
        """Arbitration ids of the drive's RPDOs."""
        return tuple(arbitration_id for arbitration_id, _, _ in self._parts)

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

    def shown_mode(self, mode: int) -> int | None:
        """The mode that the drive shows (6061h), as soon as it is `mode`, or after a time; None: it shows none."""
        deadline = time.monotonic() + _MODE_TIMEOUT
        while (shown := self.sdo.read_optional(0x6061, 0, "<b")) not in (None, mode):
            if time.monotonic() >= deadline:
                break
        return shown

    # One cycle

    def begin_cycle(self) -> None:
        """Discard the answer to the previous SYNC."""
        self._received.clear()
        self._misfit = ""
        self._raw = dict.fromkeys(self._raw, math.nan)
        self.voltage_stamp = 0

    def take_tpdo(self, arbitration_id: int, data: bytes) -> bool:
        """Decode one TPDO; False where its length is not the mapped one."""
        number, fields, layout = self._layout[arbitration_id]
        if len(data) != layout.size:
            self._misfit = f"its TPDO (COB-ID {arbitration_id:03X}h) has {len(data)} bytes, {layout.size} are mapped"
            return False
        values = dict(zip((field.name for field in fields), layout.unpack(data), strict=True))
        if "position" in values:
            before, self.counts = self.counts, values.pop("position")
            still = before is not None and abs(self.counts - before) <= self._still_counts
            self.still_answers = self.still_answers + 1 if still else 0
        if "status" in values:
            self.statusword = values.pop("status")
            self.decode_status()
            self.answers_since_emcy = self.answers_since_emcy + 1 if self.error_code else 0
        self._raw |= values
        self._received.add(number)
        return True

    @property
    def answered(self) -> bool:
        """True when all TPDOs of this cycle have arrived."""
        return len(self._received) == len(self._layout)

    @property
    def absence(self) -> str:
        """What is known of an answer that is missing; "": nothing."""
        if self.nmt_state in _NO_PDOS and not self._misfit:
            heartbeat = f"COB-ID {0x700 + self.drive.node_id:03X}h"
            return f"its heartbeat ({heartbeat}) says that it is {_NO_PDOS[self.nmt_state]}, in which it sends no PDO"
        return self._misfit

    def take_polled_voltage(self, raw: int, stamp: int) -> None:
        """Store a voltage that was read by SDO and arrived at `stamp` [ns]."""
        self._raw["voltage"] = raw
        self.voltage_stamp = stamp

    def decode_status(self) -> None:
        """Decode power state and target following from the statusword."""
        self.state = cia402.decode(self.statusword)
        follows = self.homing or self.state is not cia402.DriveState.ENABLED
        follows = follows or bool(self.statusword & cia402.TARGET_FOLLOWED)
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
            self.error_code, self.error_text = message.code, self.text_of(message.code)
        elif message.code:
            self.warnings[message.code] += 1
        else:
            self.clear_errors()
        return message

    def text_of(self, code: int) -> str:
        """Words for an error code: those of the rig file, else of the standard."""
        return self.drive.emcy.get(f"{code:04X}", emcy.describe(code))

    def clear_errors(self) -> None:
        """Forget the errors that were reported."""
        self.last_code = self.error_code = self.answers_since_emcy = 0
        self.error_text = ""

    def trouble(self, cycle: int, heartbeat_timeout: int, following_timeout: int) -> str | None:
        """Reason to end the run in `cycle`, or None. `heartbeat_timeout`: cycles without a heartbeat;
        `following_timeout`: answers without following the target."""
        if self.restarted:
            return f"{self.name}: the drive restarted (boot-up message)"
        if self.state in (cia402.DriveState.FAULT, cia402.DriveState.FAULT_REACTION):
            if self.error_code:
                return f"{self.name}: drive fault, {self.error_text} (0x{self.error_code:04X})"
            self.fault_without_emcy = True
            return f"{self.name}: drive fault without EMCY"
        if self.error_code and not self.answered:
            return f"{self.name}: no answer after {self.error_text} (EMCY 0x{self.error_code:04X})"
        if self.answers_since_emcy > 1:
            # A fault in the statusword would be the better reason, and has had time to arrive.
            return f"{self.name}: EMCY 0x{self.error_code:04X}: {self.error_text}"
        if self.answered and self.state is None:
            return f"{self.name}: statusword 0x{self.statusword:04X} fits no state of CiA 402"
        if self.answers_without_following >= following_timeout:
            return f"{self.name}: enabled, but the target is not followed (statusword bit 12); check its mode"
        if self.last_heartbeat_cycle is not None and cycle - self.last_heartbeat_cycle > heartbeat_timeout:
            return f"{self.name}: heartbeat lost; check the cable and the drive's supply"
        return None
