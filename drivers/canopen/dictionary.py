"""The objects that a drive really has, among those that the set-up uses, read before anything is written."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from drivers.canopen import units
from drivers.canopen.node_axes import FURTHER_AXES, PDOS_PER_AXIS, of_axis
from drivers.canopen.requirement import Requirement
from drivers.canopen.requirements import RPDO_TIMEOUT, SLOW_DOWN, STANDARD, TABLE, WATCHDOG, heartbeat_value
from drivers.canopen.sdo import ObjectMissing, ObjectRefused, Sdo, SdoWrite, format_address
from drivers.eds import Address, ObjectDescription, load_dictionary
from recordings.drives import STATUSWORD, HomedBit, Voltage, WatchedObject
from recordings.errors import RunFailed
from recordings.rig import Drive

_STANDARD = {**STANDARD, **units.OBJECTS}
_LAYOUTS = {1: "b", 2: "h", 4: "i"}
RECEIVE, TRANSMIT = 0x1400, 0x1800
PREDEFINED = {RECEIVE: 0x200, TRANSMIT: 0x180}
MAPPING = 0x200
"""Distance of the mapping from the parameters of a PDO."""
_MAPPED = {RECEIVE: 3, TRANSMIT: 4}
"""Largest number of objects that are mapped into one PDO; a PDO with as many entries leaves no question."""
MOST_ENTRIES = 8
"""Objects that a PDO takes where the drive does not say it."""
_MANY_PDOS = 8
"""PDO numbers that are tried in any case; the search ends after as many that do not exist."""
_MAKERS = range(0x2000, 0x6000)
_MAPPINGS = {*range(0x1600, 0x1800), *range(0x1A00, 0x1C00)}
"""Indices of the mappings of PDOs."""
_MOST_NAMED = 3
_SHARED = (
    "several axes share the objects of one node, where CiA 402 gives axis 2 those from 6800h on; this program drives "
    "only these, so take a drive for each axis"
)


def layout_of(size: int, *, signed: bool) -> str | None:
    """Struct format of an integer of `size` bytes; None where there is none."""
    code = _LAYOUTS.get(size)
    return None if code is None else "<" + (code if signed else code.upper())


@dataclass(frozen=True)
class DriveDictionary:
    """Objects of one drive and the values that they had."""

    drive: Drive
    data: Mapping[Address, bytes | None]
    """None: the object exists, but cannot be read."""
    descriptions: Mapping[Address, ObjectDescription] = field(default_factory=dict)
    """Access, limits and names of the objects by the drive's file; empty: there is none, and they are not known."""

    def __contains__(self, address: Address) -> bool:
        return address in self.data

    def layout(self, address: Address, standard: str) -> str:
        """Struct format of an integer object: of the size that the drive has, with the sign of `standard`."""
        data = self.data.get(address)
        return (layout_of(len(data), signed=standard.islower()) if data else None) or standard

    def value(self, address: Address, standard: str | None = None) -> int | None:
        """Value of an integer object; None where the drive has none or refuses to read it."""
        data = self.data.get(address)
        if not data:
            return None
        layout = layout_of(len(data), signed=(standard or _STANDARD.get(address, "<I")).islower())
        return None if layout is None else int(struct.unpack(layout, data)[0])

    def lack(self, row: Requirement) -> str:
        """Why the run cannot use an object as it needs to, whatever it writes; "": it can, as far as is known."""
        index, sub = row.address
        data, item = self.data.get(row.address), self.descriptions.get(row.address)
        if sub == 0 and (data is None or row.may_be_count(data)) and self.data.get((index, 1)):
            return f"{index:04X}h is divided into sub-indices: {_SHARED}"
        if row.address not in self:
            return f"no such object{self._beside(row)}"
        if "m" in row.use and item is not None and not (item.mappable or self.doubt(row)):
            return "cannot be mapped into a PDO"
        if "r" in row.use and (data is None if item is None else not item.is_readable):
            return "cannot be read"
        if "m" in row.use and data and len(data) not in row.sizes:
            return f"{struct.calcsize(row.layout)} bytes expected, {len(data)} found"
        if "mw" in row.use and item is not None and not item.is_writable:
            return f"read only ({item.access})"
        if row.role == "safety" and self.misnamed(row):
            return f"{self.misnamed(row)}{self._beside(row)}"
        return ""

    def doubt(self, row: Requirement) -> str:
        """That a PDO holds an object which cannot be mapped by the drive's file; "": neither, or not both."""
        item = self.descriptions.get(row.address)
        if "m" not in row.use or item is None or item.mappable:
            return ""
        # Those that the file delivers: those of the drive differ once a rig file has set it up.
        mapped = [each.value for (index, sub), each in self.descriptions.items() if sub and index in _MAPPINGS]
        entries = (int.from_bytes(value or b"", "little") for value in mapped)
        is_doubtful = any((entry >> 16, entry >> 8 & 0xFF) == row.address for entry in entries)
        return "mapped as delivered, though the dictionary says that it cannot be" if is_doubtful else ""

    def _beside(self, row: Requirement) -> str:
        """What a drive has in place of an object, or beside one that is named as something else."""
        index, sub = row.address
        others = [(index, 0 if sub else 1), *row.likewise] if row.address not in self else row.likewise
        found = [f"{format_address(*other)} is there" for other in others if other in self]
        found += [
            f'{format_address(*address)} is named "{item.name}"'
            for address, item in self.descriptions.items()
            if address[0] in _MAKERS and row.resembles(item.name)
        ]
        return f" ({'; '.join(found[:_MOST_NAMED])})" if found else ""

    def refusal(self, write: SdoWrite) -> str:
        """Why the drive will refuse a value by its file, for a drive does not say its limits; "": it will not, or has
        the value already."""
        address = write.index, write.sub
        item, present = self.descriptions.get(address), self.value(address, write.layout)
        if item is None:
            return "no such object" if self.descriptions and address not in self else ""
        if write.check and present is not None and not (present ^ write.value) & write.mask:
            return ""
        if not item.is_writable:
            return f"read only ({item.access}), and holds another value"
        low, high = item.low, item.high
        if (low is None or write.value >= low) and (high is None or write.value <= high):
            return ""
        return f"takes {item.span}, {write.value} is needed"

    @property
    def tells_status(self) -> bool:
        """Whether the statusword can be read, whatever else it lacks."""
        return len(self.data.get((STATUSWORD, 0)) or b"") >= struct.calcsize(STANDARD[STATUSWORD, 0])

    def refuses(self, address: Address, value: int) -> str:
        """See `refusal`, of a value of an object of the table."""
        return self.refusal(SdoWrite(*address, self.layout(address, STANDARD[address]), value))

    def misnamed(self, row: Requirement) -> str:
        """What the drive's file calls an object, against what the standard says of it; "": nothing else."""
        item = self.descriptions.get(row.address)
        return f'named "{item.name}" in the dictionary' if item is not None and row.contradicts(item.name) else ""

    def after(self, writes: Sequence[SdoWrite]) -> "DriveDictionary":
        """The dictionary after `writes`, which change the values of its objects."""
        values = {(write.index, write.sub): write for write in writes}
        data = {
            address: struct.pack(values[address].layout, values[address].value) if address in values else present
            for address, present in self.data.items()
        }
        return replace(self, data=data)

    @cached_property
    def units(self) -> units.Units:
        """Units of position, velocity and acceleration."""
        values = {address: self.value(address) for address in units.OBJECTS}
        return units.Units({address: value for address, value in values.items() if value is not None}, self.drive)

    @property
    def rated_torque(self) -> float:
        """Rated torque at the joint [N m]: 6076h times the gear, or that of the rig file where the drive has none."""
        return (self.value((0x6076, 0)) or 0) / 1000 * self.drive.gear or self.drive.rated_torque

    @property
    def has_ramp(self) -> bool:
        """Whether the set-up writes a deceleration, so that its unit must be known."""
        return (0x6085, 0) in self.data or (self.slows_down and (0x6084, 0) in self.data)

    @property
    def slows_down(self) -> bool:
        """Whether a stop uses the slow down ramp (6084h)."""
        return self.drive.quick_stop_option in SLOW_DOWN or self.drive.fault_reaction_option in SLOW_DOWN

    @property
    def watchdog(self) -> str | None:
        """The way in which the drive notices a lost master; 1016h where the rig file does not do without it. A drive
        that has no heartbeat of its own (1017h) is guarded: CiA 301 allows one of both."""
        can_be_guarded = (0x100C, 0) in self.data and (0x100D, 0) in self.data
        refused = self.lack(WATCHDOG) or self.refuses(WATCHDOG.address, heartbeat_value())
        if "1016" not in self.drive.accept_missing and not refused:
            return "heartbeat" if (0x1017, 0) in self.data or not can_be_guarded else "guarding"
        if can_be_guarded:
            return "guarding"
        # A drive whose first RPDO maps one object may get its targets by another.
        return "rpdo" if RPDO_TIMEOUT in self.data and self.entries(RECEIVE).get(0) != 1 else None

    def pdos(self, first: int) -> dict[int, int]:
        """COB-ID of each PDO, by its number from 0; `first`: RECEIVE or TRANSMIT."""
        return {
            index - first: self.value((index, 1)) or 0
            for index, sub in self.data
            if sub == 1 and first <= index < first + MAPPING
        }

    def entries(self, first: int) -> dict[int, int]:
        """Number of objects that each PDO can map, by its number from 0; 8 where it is not known."""
        known = set(self.descriptions or self.data)
        return {number: self._entries(first + MAPPING + number, known) for number in self.pdos(first)}

    def _entries(self, mapping: int, known: set[Address]) -> int:
        """Number of entries of a mapping, from the first one on, among what is `known`."""
        item = self.descriptions.get((mapping, 0))
        most = MOST_ENTRIES if item is None or item.high is None else min(item.high, MOST_ENTRIES)
        is_silent = not self.descriptions and not any((mapping, sub) in known for sub in range(1, most + 1))
        return next((sub for sub in range(most) if (mapping, sub + 1) not in known and not is_silent), most)


def read_dictionary(drive: Drive, sdo: Sdo) -> DriveDictionary:
    """Read the objects of a drive; writes nothing.

    Raises:
        RunFailed: the drive stops answering.
    """
    data: dict[Address, bytes | None] = {}
    asked: list[Voltage | WatchedObject | HomedBit] = [drive.voltage, *drive.watched]
    asked += [drive.homed] if drive.homed else []
    for address in dict.fromkeys((*_STANDARD, *((each.index, each.sub) for each in asked))):
        _read(sdo, address, data)
    for row in TABLE:
        index, sub = row.address
        if row.role != "convenience" and (row.address not in data or row.may_be_count(data[row.address])):
            for address in ((index, 0 if sub else 1), *row.likewise):
                _read(sdo, address, data)
    for first in (RECEIVE, TRANSMIT):
        _read_pdos(sdo, first, data)
    return DriveDictionary(drive, data, descriptions_of(drive))


def descriptions_of(drive: Drive) -> Mapping[Address, ObjectDescription]:
    """What the file in `eds` or `dcf` of a drive says of its objects, at the indices of a first axis; empty: no file.

    Raises:
        BadInput: as `load_dictionary`.
    """
    file = drive.eds or drive.dcf
    return {} if file is None else of_axis(load_dictionary(Path(file), drive.node_id), drive.axis)


def _read(sdo: Sdo, address: Address, data: dict[Address, bytes | None]) -> None:
    index, sub = address
    try:
        content, standard = sdo.read_bytes(index, sub), _STANDARD.get(address)
        data[address] = content if sdo.is_sized or standard is None else content[: struct.calcsize(standard)]
    except ObjectMissing:
        pass
    except ObjectRefused:
        data[address] = None


def _read_pdos(sdo: Sdo, first: int, data: dict[Address, bytes | None]) -> None:
    number = missing = 0
    while number < MAPPING and missing < _MANY_PDOS:
        if number == PDOS_PER_AXIS and any(sdo.has(controlword, 0) for controlword in FURTHER_AXES):
            break
        _read(sdo, (first + number, 1), data)
        missing = 0 if (first + number, 1) in data else missing + 1
        number += 1
    for existing in range(number):
        if (first + existing, 1) not in data:
            continue
        for address in ((first + existing, 2), (first + existing + MAPPING, 0)):
            _read(sdo, address, data)
        if _read_entries(sdo, first + existing + MAPPING, _MAPPED[first], data):
            return


def _read_entries(sdo: Sdo, mapping: int, wanted: int, data: dict[Address, bytes | None]) -> bool:
    """Read the entries of a PDO's mapping up to the first that does not exist; True if there are `wanted` ones."""
    for sub in range(1, wanted + 1):
        _read(sdo, (mapping, sub), data)
        if (mapping, sub) not in data:
            return False
    return True


def standard_dictionary(drive: Drive) -> DriveDictionary:
    """A drive that has all objects and counts in increments: for what is computed without a bus."""
    data: dict[Address, bytes | None] = {a: bytes(struct.calcsize(layout)) for a, layout in STANDARD.items()}
    data[0x60AA, 0] = struct.pack("<I", 0x00B5_5700)
    data.setdefault((drive.voltage.index, drive.voltage.sub), bytes(2))
    for first, count in ((RECEIVE, 1), (TRANSMIT, 2)):
        for number in range(count):
            data[first + number, 1] = struct.pack("<I", PREDEFINED[first] + 0x100 * number + drive.node_id)
    return DriveDictionary(drive, data)


def integer_at(sdo: Sdo, index: int, sub: int) -> int:
    """Unsigned integer of an object of any size.

    Raises:
        RunFailed: no answer, the drive refuses, or the object is no integer of up to 8 bytes.
    """
    data = sdo.read_bytes(index, sub)
    if not 0 < len(data) <= 8:
        raise RunFailed(f"object {index:04X}:{sub:02X}: an integer expected, {len(data)} bytes found")
    return int.from_bytes(data, "little")
