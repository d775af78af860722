"""PDOs of one drive: what is mapped into them, how they are set up, and which of them are not ours."""

from dataclasses import dataclass

from drivers.canopen.dictionary import RECEIVE, TRANSMIT, DriveDictionary, layout_of, standard_dictionary
from drivers.canopen.sdo import SdoWrite
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

_INVALID, _NO_REMOTE = 0x8000_0000, 0x4000_0000
_COB_ID_BITS = _INVALID | 0x2000_07FF
"""Bits of a COB-ID that are read back as they were written: valid, frame format, identifier."""
_TARGET = {"cyclic": 0x607A_00_20, "interpolated": 0x60C1_01_20}
_TORQUE = {"torque_actual": (0x6077, 0), "current_actual": (0x6078, 0)}
_LARGEST = 8
"""Data bytes of a PDO."""


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
        return (self.mapped & 0xFF) // 8


def tpdos(drive: Drive, dictionary: DriveDictionary | None = None) -> list[list[PdoField]]:
    """Objects that the drive sends after SYNC, one list per TPDO; sizes as in the drive, or the standard ones.

    Raises:
        BadInput: an object has a size that cannot be mapped.
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
    pdos: list[list[PdoField]] = [[]]
    for field in fields:
        if sum(mapped.size for mapped in pdos[-1]) + field.size > _LARGEST:
            pdos.append([])
        pdos[-1].append(field)
    return pdos


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


def tpdos_by_size(drive: Drive) -> list[list[list[PdoField]]]:
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


def tpdo_id(drive: Drive, number: int) -> int:
    """Arbitration id of TPDO `number` (from 0) in the predefined connection set."""
    return 0x180 + 0x100 * number + drive.node_id


def pdo_sizes(drive: Drive, dictionary: DriveDictionary | None = None) -> list[int]:
    """Data bytes of each PDO of one drive in a cycle."""
    return [6, *(sum(field.size for field in fields) for fields in tpdos(drive, dictionary))]


def pdo_writes(drive: Drive, dictionary: DriveDictionary) -> list[SdoWrite]:
    """SDO downloads that switch off the drive's other PDOs and set up ours.

    Raises:
        BadInput: the drive has too few PDOs, or an object cannot be mapped.
    """
    transmitted = tpdos(drive, dictionary)
    counts = {RECEIVE: 1, TRANSMIT: len(transmitted)}
    for first, count in counts.items():
        numbers = dictionary.pdos(first)
        if any(number not in numbers for number in range(count)):
            kind = "RPDO" if first == RECEIVE else "TPDO"
            raise BadInput(
                f"node {drive.node_id}: {count} {kind}(s) needed, {len(numbers)} found in the drive; record less by "
                'PDO (voltage.transfer = "sdo", torque_actual = false)'
            )
    writes = [write for first, count in counts.items() for write in _switch_off(dictionary, first, count)]
    writes += _pdo(dictionary, RECEIVE, 0x200 + drive.node_id, [0x6040_00_10, _TARGET[drive.mode]])
    for number, fields in enumerate(transmitted):
        writes += _pdo(dictionary, TRANSMIT + number, tpdo_id(drive, number), [field.mapped for field in fields])
    return writes


def _switch_off(dictionary: DriveDictionary, first: int, ours: int) -> list[SdoWrite]:
    return [
        SdoWrite(first + number, 1, "<I", cob_id | _INVALID, mask=_INVALID)
        for number, cob_id in dictionary.pdos(first).items()
        if number >= ours and not cob_id & _INVALID
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
