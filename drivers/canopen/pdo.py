"""PDOs of one drive: what is mapped into them, how they are set up, and which of them are not ours."""

from collections.abc import Container
from dataclasses import dataclass
from itertools import accumulate

from drivers.canopen.dictionary import RECEIVE, TRANSMIT, DriveDictionary, layout_of, standard_dictionary
from drivers.canopen.sdo import SdoWrite
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

_INVALID, _NO_REMOTE = 0x8000_0000, 0x4000_0000
_COB_ID_BITS = _INVALID | 0x2000_07FF
"""Bits of a COB-ID that are read back as they were written: valid, frame format, identifier."""
_CONTROLWORD, _TORQUE_OFFSET = 0x6040_00_10, 0x60B2_00_10
_TARGET = {"cyclic": 0x607A_00_20, "interpolated": 0x60C1_01_20}
_TORQUE = {"torque_actual": (0x6077, 0), "current_actual": (0x6078, 0)}
_LARGEST = 8
"""Data bytes of a PDO."""
_MOST_ENTRIES = 8
"""Objects that a PDO takes where the drive does not say it."""


@dataclass(frozen=True)
class PdoField:
    """One object mapped into a TPDO."""

    name: str
    mapped: int
    """Index, sub-index and length in bits, as in the mapping object."""
    layout: str

    @property
    def size(self) -> int:
        """Length [bytes]."""
        return size_of(self.mapped)


def tpdos(drive: Drive, dictionary: DriveDictionary | None = None) -> dict[int, list[PdoField]]:
    """Objects that the drive sends after SYNC, by the number of their TPDO (from 0); sizes as in the drive, or the
    standard ones.

    Raises:
        BadInput: an object has a size that cannot be mapped, or the drive has too few TPDOs.
    """
    dictionary = dictionary or standard_dictionary(drive)
    fields = [PdoField("status", 0x6041_00_10, "H"), PdoField("position", 0x6064_00_20, "i")]
    voltage = drive.voltage
    if drive.torque_source == "voltage" and voltage.transfer == "pdo":
        signed = voltage_is_signed(drive)
        fields.append(_field("voltage", (voltage.index, voltage.sub), dictionary, signed=signed))
    if drive.torque_actual or drive.torque_source != "voltage":
        fields.append(
            _field("torque", _TORQUE.get(drive.torque_source, _TORQUE["torque_actual"]), dictionary, signed=True)
        )
    sizes = [field.size for field in fields]
    return {number: fields[part] for number, part in _placed(dictionary, TRANSMIT, sizes).items()}


def rpdos(drive: Drive, dictionary: DriveDictionary | None = None) -> dict[int, list[int]]:
    """Objects that the drive receives before SYNC, as in the mapping object, by the number of their RPDO (from 0).

    In the order of controlword, target and torque offset.

    Raises:
        BadInput: the drive has too few RPDOs.
    """
    objects = [_CONTROLWORD, _TARGET[drive.mode], *([_TORQUE_OFFSET] if drive.torque_offset else [])]
    sizes = [size_of(mapped) for mapped in objects]
    placed = _placed(dictionary or standard_dictionary(drive), RECEIVE, sizes)
    return {number: objects[part] for number, part in placed.items()}


def size_of(mapped: int) -> int:
    """Length of a mapped object [bytes]."""
    return (mapped & 0xFF) // 8


def _placed(dictionary: DriveDictionary, first: int, sizes: list[int]) -> dict[int, slice]:
    """Spread objects over the drive's PDOs in their order: the part of the objects for each PDO, by its number.

    Each part goes to the PDO that takes most of what remains, the first of equal ones: some drives map one object
    into a PDO and two into the next. Entries that cannot be read may exist once a longer mapping is written.
    """
    for entries in (dictionary.entries(first), dict.fromkeys(dictionary.entries(first), _MOST_ENTRIES)):
        placed, free, begin = {}, entries, 0
        while begin < len(sizes):
            number = max(free, key=lambda n: _fitting(sizes[begin:], free[n]), default=None)
            if number is None or not (count := _fitting(sizes[begin:], free[number])):
                break
            placed[number] = slice(begin, begin + count)
            begin += count
            free = {other: room for other, room in free.items() if other != number}
        else:
            return placed
    kind = "RPDO" if first == RECEIVE else "TPDO"
    raise BadInput(
        f"node {dictionary.drive.node_id}: {len(placed) + 1} {kind}(s) or more needed, {len(entries)} found in the "
        'drive; record less by PDO (voltage.transfer = "sdo", torque_actual = false)'
    )


def _fitting(sizes: list[int], entries: int) -> int:
    """Number of objects, the first ones, that a PDO with so many entries takes."""
    return sum(total <= _LARGEST for total in accumulate(sizes[:entries]))


def effort_per_count(rig: Rig, joint: int) -> float:
    """Joint torque [N m] per count of the torque or current that drive `joint` (from 0) sends, with its sign."""
    drive = rig.drives[joint]
    if drive.torque_source == "current_actual":
        assert drive.rated_current is not None
        return drive.sign * drive.rated_current / 1000 * rig.torque.per_ampere[joint]
    return drive.sign * drive.rated_torque / 1000


def measures_effort(rig: Rig) -> bool:
    """Whether drives send torque or current."""
    return any(drive.torque_actual or drive.torque_source != "voltage" for drive in rig.drives)


def tpdos_by_size(drive: Drive) -> list[dict[int, list[PdoField]]]:
    """`tpdos` for each size that the voltage object may have, the usual one first: for frames of an unknown drive."""
    address, standard = (drive.voltage.index, drive.voltage.sub), standard_dictionary(drive)
    return [tpdos(drive, DriveDictionary(drive, {**standard.data, address: bytes(size)})) for size in (2, 4, 1)]


def voltage_is_signed(drive: Drive) -> bool:
    """Sign of the voltage object: that of the rig file, else of the standard (6079h has none), else signed."""
    return drive.voltage.index != 0x6079 if drive.voltage.signed is None else drive.voltage.signed


def _field(name: str, address: tuple[int, int], dictionary: DriveDictionary, *, signed: bool) -> PdoField:
    size = len(dictionary.data.get(address) or bytes(2))
    layout = layout_of(size, signed=signed)
    if layout is None:
        raise BadInput(
            f"node {dictionary.drive.node_id}: object {address[0]:04X}:{address[1]:02X} has {size} bytes, 1, 2 or 4 "
            f"expected for the {name}; choose another object"
        )
    return PdoField(name, address[0] << 16 | address[1] << 8 | 8 * size, layout[1:])


def rpdo_id(drive: Drive, number: int) -> int:
    """Arbitration id of RPDO `number` (from 0) in the predefined connection set."""
    return 0x200 + 0x100 * number + drive.node_id


def tpdo_id(drive: Drive, number: int) -> int:
    """Arbitration id of TPDO `number` (from 0) in the predefined connection set."""
    return 0x180 + 0x100 * number + drive.node_id


def pdo_sizes(drive: Drive, dictionary: DriveDictionary | None = None) -> list[int]:
    """Data bytes of each PDO of one drive in a cycle."""
    received = [sum(map(size_of, objects)) for objects in rpdos(drive, dictionary).values()]
    return [*received, *(sum(field.size for field in fields) for fields in tpdos(drive, dictionary).values())]


def pdo_writes(drive: Drive, dictionary: DriveDictionary) -> list[SdoWrite]:
    """SDO downloads that switch off the drive's other PDOs and set up ours.

    Raises:
        BadInput: the drive has too few PDOs, or an object cannot be mapped.
    """
    received = {number: (rpdo_id(drive, number), objects) for number, objects in rpdos(drive, dictionary).items()}
    transmitted = {
        number: (tpdo_id(drive, number), [field.mapped for field in fields])
        for number, fields in tpdos(drive, dictionary).items()
    }
    ours = {RECEIVE: received, TRANSMIT: transmitted}
    writes = [write for first, pdos in ours.items() for write in _switch_off(dictionary, first, pdos)]
    for first, pdos in ours.items():
        for number, (cob_id, objects) in pdos.items():
            writes += _pdo(dictionary, first + number, cob_id, objects)
    return writes


def _switch_off(dictionary: DriveDictionary, first: int, ours: Container[int]) -> list[SdoWrite]:
    return [
        SdoWrite(first + number, 1, "<I", cob_id | _INVALID, mask=_INVALID)
        for number, cob_id in dictionary.pdos(first).items()
        if number not in ours and not cob_id & _INVALID
    ]


def is_foreign(write: SdoWrite) -> bool:
    """Whether a write switches off a PDO that is not ours."""
    return write.mask == _INVALID


def _pdo(dictionary: DriveDictionary, parameters: int, cob_id: int, objects: list[int]) -> list[SdoWrite]:
    # Order required by CiA 301: disable the PDO, clear the mapping, write it, set its length, enable the PDO. Bit 30
    # stays as it is: a drive that answers no remote frames may refuse to clear it.
    present = dictionary.value((parameters, 1), "<I") or 0
    mapping = parameters + 0x200
    return [
        SdoWrite(parameters, 1, "<I", present | _INVALID, check=False),
        SdoWrite(parameters, 2, "<B", 1),  # synchronous, every SYNC
        SdoWrite(mapping, 0, "<B", 0, check=False),
        *(SdoWrite(mapping, i + 1, "<I", mapped) for i, mapped in enumerate(objects)),
        SdoWrite(mapping, 0, "<B", len(objects)),
        SdoWrite(parameters, 1, "<I", cob_id | present & _NO_REMOTE, mask=_COB_ID_BITS),
    ]
