"""The objects that a drive really has, among those that the set-up uses, read before anything is written."""

import struct
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from drivers.canopen import units
from drivers.canopen.node_axes import FURTHER_AXES, PDOS_PER_AXIS
from drivers.canopen.sdo import ObjectMissing, ObjectRefused, Sdo, SdoWrite
from drivers.eds import Address
from recordings.drives import STATUSWORD
from recordings.errors import RunFailed
from recordings.rig import Drive

STANDARD: dict[Address, str] = {
    **{(0x1006, 0): "<I", (0x1016, 1): "<I", (0x1017, 0): "<H", (0x100C, 0): "<H", (0x100D, 0): "<B"},
    **{(0x6007, 0): "<h", (0x603F, 0): "<H", (STATUSWORD, 0): "<H", (0x605A, 0): "<h", (0x605D, 0): "<h"},
    **{(0x605E, 0): "<h", (0x6060, 0): "<b", (0x6061, 0): "<b", (0x6064, 0): "<i", (0x6065, 0): "<I"},
    **{(0x6066, 0): "<H", (0x6075, 0): "<I", (0x6076, 0): "<I", (0x6077, 0): "<h", (0x6078, 0): "<h"},
    **{(0x6079, 0): "<I", (0x607A, 0): "<i", (0x607D, 1): "<i", (0x607D, 2): "<i", (0x6084, 0): "<I"},
    **{
        (0x6085, 0): "<I",
        (0x60B2, 0): "<h",
        (0x60C1, 1): "<i",
        (0x60C2, 1): "<B",
        (0x60C2, 2): "<b",
        (0x6502, 0): "<I",
    },
}
"""Objects of CiA 301 and CiA 402 that the set-up or the check reads or writes, with their standard types."""

_LAYOUTS = {1: "b", 2: "h", 4: "i"}
RECEIVE, TRANSMIT = 0x1400, 0x1800
SLOW_DOWN = (1, 5)
"""Option codes that stop on 6084 instead of 6085."""
PREDEFINED = {RECEIVE: 0x200, TRANSMIT: 0x180}
MAPPING = 0x200
"""Distance of the mapping from the parameters of a PDO."""
_MAPPED = {RECEIVE: 3, TRANSMIT: 4}
"""Largest number of objects that are mapped into one PDO; a PDO with as many entries leaves no question."""
_MANY_PDOS = 8
"""PDO numbers that are tried in any case; the search ends after as many that do not exist."""


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
        layout = layout_of(len(data), signed=(standard or STANDARD.get(address, "<I")).islower())
        return None if layout is None else int(struct.unpack(layout, data)[0])

    def after(self, writes: Sequence[SdoWrite]) -> "DriveDictionary":
        """The dictionary after `writes`, which change the values of its objects."""
        values = {(write.index, write.sub): write for write in writes}
        data = {
            address: struct.pack(values[address].layout, values[address].value) if address in values else present
            for address, present in self.data.items()
        }
        return DriveDictionary(self.drive, data)

    @cached_property
    def units(self) -> units.Units:
        """Units of position, velocity and acceleration."""
        values = {address: self.value(address, layout) for address, layout in units.OBJECTS.items()}
        return units.Units({address: value for address, value in values.items() if value is not None}, self.drive)

    @property
    def rated_torque(self) -> float:
        """Rated torque at the joint [N m]: 6076h times the gear, or that of the rig file where the drive has none."""
        return (self.value((0x6076, 0)) or 0) / 1000 * self.drive.gear or self.drive.rated_torque

    @property
    def has_ramp(self) -> bool:
        """Whether the set-up writes a deceleration, so that its unit must be known."""
        slow_down = self.drive.quick_stop_option in SLOW_DOWN or self.drive.fault_reaction_option in SLOW_DOWN
        return (0x6085, 0) in self.data or (slow_down and (0x6084, 0) in self.data)

    @property
    def watchdog(self) -> str | None:
        """The way in which the drive notices a lost master; 1016h where the rig file does not do without it. A drive
        that has no heartbeat of its own (1017h) is guarded: CiA 301 allows one of both."""
        can_be_guarded = (0x100C, 0) in self.data and (0x100D, 0) in self.data
        if (0x1016, 1) in self.data and "1016" not in self.drive.accept_missing:
            return "heartbeat" if (0x1017, 0) in self.data or not can_be_guarded else "guarding"
        if can_be_guarded:
            return "guarding"
        # A drive whose first RPDO maps one object may get its targets by another.
        return "rpdo" if (RECEIVE, 5) in self.data and self.entries(RECEIVE).get(0) != 1 else None

    def pdos(self, first: int) -> dict[int, int]:
        """COB-ID of each PDO, by its number from 0; `first`: RECEIVE or TRANSMIT."""
        return {
            index - first: self.value((index, 1)) or 0
            for index, sub in self.data
            if sub == 1 and first <= index < first + MAPPING
        }

    def entries(self, first: int) -> dict[int, int]:
        """Number of objects that each PDO can map, by its number from 0; 8 where it is not known."""
        mapped = Counter(index - first - MAPPING for index, sub in self.data if sub and index >= first + MAPPING)
        return {number: mapped[number] or 8 for number in self.pdos(first)}


def read_dictionary(drive: Drive, sdo: Sdo) -> DriveDictionary:
    """Read the objects of a drive; writes nothing.

    Raises:
        RunFailed: the drive stops answering.
    """
    voltage = (drive.voltage.index, drive.voltage.sub)
    data: dict[Address, bytes | None] = {}
    for address in (*STANDARD, *units.OBJECTS, voltage, (RECEIVE, 5)):
        _read(sdo, address, data)
    for first in (RECEIVE, TRANSMIT):
        _read_pdos(sdo, first, data)
    return DriveDictionary(drive, data)


def _read(sdo: Sdo, address: Address, data: dict[Address, bytes | None]) -> None:
    index, sub = address
    try:
        data[address] = sdo.read_bytes(index, sub)
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
        if (first + existing, 1) in data and _read_entries(sdo, first + existing + MAPPING, _MAPPED[first], data):
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
