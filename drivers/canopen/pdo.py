"""PDOs of one drive: what is mapped into them, how they are set up, which are not ours; load of the bus by all."""

import struct
from collections.abc import Container, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

from drivers.canopen.bus import frame_bits
from drivers.canopen.dictionary import (
    MAPPING,
    MOST_ENTRIES,
    PREDEFINED,
    RECEIVE,
    TRANSMIT,
    DriveDictionary,
    layout_of,
    standard_dictionary,
)
from drivers.canopen.node_axes import on_node
from drivers.canopen.sdo import SdoWrite, format_address
from drivers.eds import Address
from recordings.drives import STATUSWORD
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

INVALID, _NO_REMOTE = 0x8000_0000, 0x4000_0000
"""Bits 31 and 30 of a COB-ID: the PDO is off; it answers no remote frames."""
_COB_ID_BITS = INVALID | 0x2000_07FF
"""Bits of a COB-ID that are read back as they were written: valid, frame format, identifier."""
_TORQUE = {"torque_actual": (0x6077, 0), "current_actual": (0x6078, 0)}
_LARGEST = 8
"""Data bytes of a PDO."""
_FIRST_OF_AXIS = (0, 2, 1, 3)
"""The first PDO of each axis, of the four each way to which CiA 301 gives a node COB-IDs: two axes have two each."""


@dataclass(frozen=True)
class PdoField:
    """One object mapped into a PDO."""

    name: str
    address: Address
    layout: str

    def mapped(self, axis: int) -> int:
        """Index, sub-index and length in bits, as in the mapping object of an axis of the node."""
        index, sub = self.address
        return on_node(index, axis) << 16 | sub << 8 | 8 * struct.calcsize(self.layout)


_CONTROLWORD, _OFFSET = PdoField("controlword", (0x6040, 0), "H"), PdoField("offset", (0x60B2, 0), "h")
TARGET = {
    "cyclic": PdoField("target", (0x607A, 0), "i"),
    "interpolated": PdoField("target", (0x60C1, 1), "i"),
}


@dataclass(frozen=True)
class Pdo:
    """One PDO of the cycle."""

    parameters: int
    """Index of its communication parameters."""
    cob_id: int
    """In the predefined connection set."""
    fields: list[PdoField]

    @property
    def name(self) -> str:
        """Kind and number from 1, as in manuals."""
        kind, first = ("RPDO", RECEIVE) if self.parameters < TRANSMIT else ("TPDO", TRANSMIT)
        return f"{kind} {self.parameters - first + 1}"

    @cached_property
    def layout(self) -> struct.Struct:
        """Layout of its data."""
        return struct.Struct("<" + "".join(field.layout for field in self.fields))


def tpdos(dictionary: DriveDictionary) -> list[Pdo]:
    """What the drive sends after SYNC, with the sizes that its objects have.

    Raises:
        BadInput: an object has a size that cannot be mapped, or the drive has too few TPDOs.
    """
    drive, voltage = dictionary.drive, dictionary.drive.voltage
    fields = [PdoField("status", (STATUSWORD, 0), "H"), PdoField("position", (0x6064, 0), "i")]
    if drive.torque_source == "voltage" and voltage.transfer == "pdo":
        signed = voltage_is_signed(drive)
        fields.append(_field("voltage", (voltage.index, voltage.sub), dictionary, signed=signed))
    if drive.measures_effort:
        fields.append(
            _field("torque", _TORQUE.get(drive.torque_source, _TORQUE["torque_actual"]), dictionary, signed=True)
        )
    return _placed(dictionary, TRANSMIT, fields)


def rpdos(dictionary: DriveDictionary) -> list[Pdo]:
    """What the drive receives before SYNC, in the order of controlword, target and torque offset.

    Raises:
        BadInput: the drive has too few RPDOs.
    """
    drive = dictionary.drive
    fields = [_CONTROLWORD, TARGET[drive.mode], *([_OFFSET] if drive.torque_offset else [])]
    return _placed(dictionary, RECEIVE, fields)


def _placed(dictionary: DriveDictionary, first: int, fields: list[PdoField]) -> list[Pdo]:
    """Spread objects over the drive's PDOs in their order.

    Each part goes to the PDO that takes most of what remains, the first of equal ones: some drives map one object
    into a PDO and two into the next. Entries that cannot be read may exist once a longer mapping is written.
    """
    usable = len(_FIRST_OF_AXIS) - _FIRST_OF_AXIS[dictionary.drive.axis - 1]
    known = {number: count for number, count in dictionary.entries(first).items() if number < usable}
    for entries in (known, dict.fromkeys(known, MOST_ENTRIES)):
        placed, free, rest = list[Pdo](), dict(entries), fields
        while rest:
            taken = {number: _taken(dictionary, first + number, rest, count) for number, count in free.items()}
            number = max(taken, key=lambda n: len(taken[n].fields), default=None)
            if number is None or not taken[number].fields:
                break
            placed.append(taken[number])
            rest = rest[len(taken[number].fields) :]
            del free[number]
        else:
            return placed
    raise BadInput(_too_few(dictionary, first, fields, len(placed) + 1, {first + number for number in known}))


def _taken(dictionary: DriveDictionary, parameters: int, fields: list[PdoField], entries: int) -> Pdo:
    """The PDO with as many of the objects, from the first on, as it takes; none where it is fixed to others."""
    cob_id = _cob_id(parameters, dictionary.drive)
    if not _fixed(dictionary, parameters):
        return Pdo(parameters, cob_id, fields[: _fitting(fields, entries)])
    as_it_is = Pdo(parameters, cob_id, fields[: dictionary.value((parameters + MAPPING, 0), "<B") or 0])
    return as_it_is if _is_mapped(dictionary, as_it_is) else Pdo(parameters, cob_id, [])


def _fixed(dictionary: DriveDictionary, parameters: int) -> list[Address]:
    """What is read only, by the drive's file, of all that must be written to map other objects into a PDO."""
    needed = (parameters, 1), (parameters + MAPPING, 0), (parameters + MAPPING, 1)
    items = dictionary.descriptions
    return [address for address in needed if address in items and not items[address].is_writable]


def _too_few(
    dictionary: DriveDictionary, first: int, fields: list[PdoField], least: int, known: Iterable[int]
) -> str:
    """Why the objects have no place, and what may be done."""
    kind, drive = ("RPDO" if first == RECEIVE else "TPDO"), dictionary.drive
    objects, count = ", ".join(format_address(*field.address) for field in fields), len(set(known))
    usable = len(_FIRST_OF_AXIS) - _FIRST_OF_AXIS[drive.axis - 1]
    if fixed := [address for parameters in known for address in _fixed(dictionary, parameters)]:
        return (
            f"{drive.address}: {format_address(*fixed[0])} is read only, so the mapping of its {kind} cannot be "
            f"changed (CiA 301 switches a PDO off for that); {objects} are needed: map them by the drive's own tool, "
            "and let it store them"
        )
    less = "" if first == RECEIVE else '; record less by PDO (voltage.transfer = "sdo", torque_actual = false)'
    return (
        f"{drive.address}: {least} {kind}(s) or more needed for {objects}, {count} found among the {usable} that "
        f"have COB-IDs{less}"
    )


def _is_mapped(dictionary: DriveDictionary, pdo: Pdo) -> bool:
    """Whether the drive has a PDO with the objects that are needed."""
    mapping, axis = pdo.parameters + MAPPING, dictionary.drive.axis
    cob_id = dictionary.value((pdo.parameters, 1))
    entries = [dictionary.value((mapping, sub)) for sub in range(1, len(pdo.fields) + 1)]
    return (
        (cob_id is not None and cob_id & _COB_ID_BITS == pdo.cob_id)
        and dictionary.value((mapping, 0), "<B") == len(pdo.fields)
        and entries == [field.mapped(axis) for field in pdo.fields]
    )


def _cob_id(parameters: int, drive: Drive) -> int:
    """COB-ID, of the predefined connection set of the node, for the PDO with these parameters."""
    first = RECEIVE if parameters < TRANSMIT else TRANSMIT
    number = parameters - first + _FIRST_OF_AXIS[drive.axis - 1]
    return PREDEFINED[first] + 0x100 * number + drive.node_id


def _fitting(fields: list[PdoField], entries: int) -> int:
    """Number of objects, the first ones, that a PDO with so many entries takes."""
    return sum(total <= _LARGEST for total in accumulate(struct.calcsize(field.layout) for field in fields[:entries]))


def effort_per_count(rig: Rig, joint: int) -> float:
    """Joint torque [N m] per count of the torque or current that drive `joint` (from 0) sends, with its sign."""
    drive = rig.drives[joint]
    if drive.torque_source == "current_actual":
        assert drive.rated_current is not None
        return drive.sign * drive.rated_current / 1000 * rig.torque.per_ampere[joint]
    return drive.sign * drive.rated_torque / 1000


def measures_effort(rig: Rig) -> bool:
    """Whether drives send torque or current."""
    return any(drive.measures_effort for drive in rig.drives)


def tpdos_by_size(drive: Drive) -> list[list[Pdo]]:
    """`tpdos` for each size that the voltage object may have, the usual one first: for frames of an unknown drive."""
    address, standard = (drive.voltage.index, drive.voltage.sub), standard_dictionary(drive)
    return [tpdos(DriveDictionary(drive, {**standard.data, address: bytes(size)})) for size in (2, 4, 1)]


def voltage_is_signed(drive: Drive) -> bool:
    """Sign of the voltage object: that of the rig file, else of the standard (6079h has none), else signed."""
    return drive.voltage.index != 0x6079 if drive.voltage.signed is None else drive.voltage.signed


def _field(name: str, address: Address, dictionary: DriveDictionary, *, signed: bool) -> PdoField:
    size = len(dictionary.data.get(address) or bytes(2))
    layout = layout_of(size, signed=signed)
    if layout is None:
        raise BadInput(
            f"{dictionary.drive.address}: object {address[0]:04X}:{address[1]:02X} has {size} bytes, 1, 2 or 4 "
            f"expected for the {name}; choose another object"
        )
    return PdoField(name, address, layout[1:])


def bus_load(
    rig: Rig, rate: float, dictionaries: Iterable[DriveDictionary] | None = None, foreign: Iterable[int] = ()
) -> float:
    """Worst-case bus load (0 ... 1) of the cycle at `rate` [Hz]: SYNC, the drives' PDOs, and one SDO request with its
    response if something is polled.

    `dictionaries`: of the drives, where they are known; `foreign`: data bytes of PDOs that drives send besides,
    counted once per cycle.

    Raises:
        BadInput: two axes of a node need the same COB-ID.
    """
    known = dictionaries or map(standard_dictionary, rig.drives)
    pdos = [pdo for each in known for pdo in (*rpdos(each), *tpdos(each))]
    for pdo in pdos:
        if sum(other.cob_id == pdo.cob_id for other in pdos) > 1:
            raise BadInput(
                f"COB-ID {pdo.cob_id:03X}h is needed by two axes of one node, which has those of four PDOs each way; "
                "record less by PDO, or drive fewer axes of this node"
            )
    sizes = [0, *foreign, *(pdo.layout.size for pdo in pdos)]
    if any(each.watched or (each.torque_source, each.voltage.transfer) == ("voltage", "sdo") for each in rig.drives):
        sizes += [8, 8]
    return sum(map(frame_bits, sizes)) * rate / rig.can.bitrate


def highest_rate(rig: Rig) -> float:
    """The rate [Hz] at which the bus load reaches the limit in the rig file."""
    return rig.can.max_load / bus_load(rig, 1.0)


def pdo_writes(dictionary: DriveDictionary) -> list[SdoWrite]:
    """SDO downloads that switch off the drive's other PDOs and set up ours.

    Raises:
        BadInput: the drive has too few PDOs, or an object cannot be mapped.
    """
    ours = [*rpdos(dictionary), *tpdos(dictionary)]
    used = {pdo.parameters for pdo in ours}
    return [*switch_off(dictionary, used), *(write for pdo in ours for write in _set_up(dictionary, pdo))]


def switch_off(dictionary: DriveDictionary, used: Container[int] = ()) -> list[SdoWrite]:
    """SDO downloads that switch off the PDOs that are on, except those whose parameters are `used`."""
    return [
        SdoWrite(first + number, 1, "<I", cob_id | INVALID, mask=INVALID)
        for first in (RECEIVE, TRANSMIT)
        for number, cob_id in dictionary.pdos(first).items()
        if first + number not in used and not cob_id & INVALID
    ]


def is_foreign(write: SdoWrite) -> bool:
    """Whether a write switches off a PDO that is not ours."""
    return write.mask == INVALID


def _set_up(dictionary: DriveDictionary, pdo: Pdo) -> list[SdoWrite]:
    # Order required by CiA 301: disable the PDO, clear the mapping, write it, set its length, enable the PDO. Bit 30
    # stays as it is: a drive that answers no remote frames may refuse to clear it.
    axis, present = dictionary.drive.axis, dictionary.value((pdo.parameters, 1), "<I") or 0
    mapping, kind = pdo.parameters + MAPPING, SdoWrite(pdo.parameters, 2, "<B", 1)  # synchronous, every SYNC
    if _is_mapped(dictionary, pdo):
        return [] if dictionary.value((pdo.parameters, 2), "<B") == kind.value else [kind]
    return [
        SdoWrite(pdo.parameters, 1, "<I", present | INVALID, check=False),
        kind,
        SdoWrite(mapping, 0, "<B", 0, check=False),
        *(SdoWrite(mapping, i, "<I", field.mapped(axis)) for i, field in enumerate(pdo.fields, start=1)),
        SdoWrite(mapping, 0, "<B", len(pdo.fields)),
        SdoWrite(pdo.parameters, 1, "<I", pdo.cob_id | present & _NO_REMOTE, mask=_COB_ID_BITS),
    ]
