"""Configuration of a CiA 402 drive: the objects to write before it moves, computed from the rig."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recordings.errors import BadInput
from recordings.rig import Drive, Rig

SYNC_ID = 0x80
MASTER_ID = 127
"""Node id under which the master sends its heartbeat."""
MASTER_HEARTBEAT = 0.05
"""Seconds between the master's heartbeats."""
MASTER_TIMEOUT_MS = 250
"""Time without a master heartbeat after which a drive stops (object 1016)."""
DRIVE_HEARTBEAT_MS = 100

_CYCLIC_SYNC_POSITION, _INTERPOLATED_POSITION = 8, 7
_TARGET = {"cyclic": 0x607A_00_20, "interpolated": 0x60C1_01_20}


@dataclass(frozen=True)
class SdoWrite:
    """One SDO download; `layout` is the struct format of its type."""

    index: int
    sub: int
    layout: str
    value: int
    check: bool = True


@dataclass(frozen=True)
class PdoField:
    """One object mapped into a TPDO."""

    name: str
    mapped: int
    """Index, sub-index and length in bits, as in the mapping object."""
    layout: str


def sdo_writes(rig: Rig, drive: Drive) -> list[SdoWrite]:
    """The SDO downloads that configure one drive, in order.

    Raises:
        BadInput: the rate or a limit does not fit its object, or the DCF cannot be read.
    """
    writes = [*_configuration_file(drive), *_motion_objects(rig, drive), *_watchdogs(), *_rpdo(drive), *_tpdo(drive)]
    for write in writes:
        try:
            struct.pack(write.layout, write.value)
        except struct.error:
            raise BadInput(
                f"node {drive.node_id}: {write.value:.6g} does not fit object {write.index:04X}:{write.sub:02X}; "
                "check counts_per_turn, gear, zero_offset and the limits in the rig file"
            ) from None
    return writes


def _motion_objects(rig: Rig, drive: Drive) -> list[SdoWrite]:
    counts = abs(drive.counts_per_radian)
    low, high = rig.limits.joint_counts(drive)
    period, exponent = interpolation_period(rig.rate)
    return [
        SdoWrite(0x6060, 0, "<b", _CYCLIC_SYNC_POSITION if drive.mode == "cyclic" else _INTERPOLATED_POSITION),
        SdoWrite(0x60C2, 1, "<B", period),
        SdoWrite(0x60C2, 2, "<b", exponent),
        SdoWrite(0x1006, 0, "<I", round(1e6 / rig.rate)),
        SdoWrite(0x6065, 0, "<I", round(rig.limits.following_error * counts)),
        SdoWrite(0x6066, 0, "<H", 10),  # ms
        SdoWrite(0x607D, 1, "<i", low),
        SdoWrite(0x607D, 2, "<i", high),
        SdoWrite(0x6085, 0, "<I", round(rig.limits.acceleration * counts)),
    ]


def _watchdogs() -> list[SdoWrite]:
    return [
        SdoWrite(0x605A, 0, "<h", 2),  # quick stop: decelerate on its ramp, then switch on disabled
        SdoWrite(0x605E, 0, "<h", 2),  # fault: likewise
        SdoWrite(0x6007, 0, "<h", 3),  # master lost: quick stop
        SdoWrite(0x1017, 0, "<H", DRIVE_HEARTBEAT_MS),
        SdoWrite(0x1016, 1, "<I", MASTER_ID << 16 | MASTER_TIMEOUT_MS),
    ]


def tpdos(drive: Drive) -> list[list[PdoField]]:
    """Objects that the drive sends after SYNC, one list per TPDO."""
    fields = [PdoField("status", 0x6041_00_10, "H"), PdoField("position", 0x6064_00_20, "i")]
    if drive.voltage.transfer == "pdo":
        fields.append(PdoField("voltage", drive.voltage.index << 16 | drive.voltage.sub << 8 | 16, "h"))
    torque = [PdoField("torque", 0x6077_00_10, "h")] if drive.torque_actual else []
    if len(fields) == 2:
        return [fields + torque]
    return [fields, torque] if torque else [fields]


def tpdo_id(drive: Drive, number: int) -> int:
    """Arbitration id of TPDO `number` (0 or 1) in the predefined connection set."""
    return 0x180 + 0x100 * number + drive.node_id


def pdo_sizes(drive: Drive) -> list[int]:
    """Data bytes of each PDO of one drive in a cycle."""
    answers = [sum(field.mapped & 0xFF for field in fields) // 8 for fields in tpdos(drive)]
    return [6, *answers]


def _rpdo(drive: Drive) -> list[SdoWrite]:
    return _pdo(0x1400, 0x1600, 0x200 + drive.node_id, [0x6040_00_10, _TARGET[drive.mode]])


def _tpdo(drive: Drive) -> list[SdoWrite]:
    return [
        write
        for number, fields in enumerate(tpdos(drive))
        for write in _pdo(
            0x1800 + number, 0x1A00 + number, tpdo_id(drive, number), [field.mapped for field in fields]
        )
    ]


def _pdo(parameters: int, mapping: int, cob_id: int, objects: list[int]) -> list[SdoWrite]:
    # Order required by CiA 301: disable the PDO, clear the mapping, write it, set its length, enable the PDO.
    return [
        SdoWrite(parameters, 1, "<I", 0x8000_0000 | cob_id, check=False),
        SdoWrite(parameters, 2, "<B", 1),  # synchronous, every SYNC
        SdoWrite(mapping, 0, "<B", 0, check=False),
        *(SdoWrite(mapping, i + 1, "<I", mapped) for i, mapped in enumerate(objects)),
        SdoWrite(mapping, 0, "<B", len(objects)),
        SdoWrite(parameters, 1, "<I", cob_id),
    ]


def _configuration_file(drive: Drive) -> list[SdoWrite]:
    """Parameter values of the drive's DCF, in the order of their addresses."""
    if drive.dcf is None:
        return []
    from canopen.objectdictionary import ODVariable, import_od

    if not Path(drive.dcf).is_file():
        raise BadInput(f"DCF {drive.dcf} of node {drive.node_id} does not exist; check the rig file")
    try:
        dictionary = import_od(drive.dcf, drive.node_id)
    except Exception as error:  # the library passes on any exception of its parsers
        raise BadInput(f"DCF {drive.dcf} of node {drive.node_id} cannot be read: {error}") from None
    variables: list[Any] = []
    for item in dictionary.values():
        variables += [item] if isinstance(item, ODVariable) else list(item.values())
    return [write for variable in variables if (write := _parameter(variable)) is not None]


def _parameter(variable: Any) -> SdoWrite | None:
    if variable.value is None or not variable.writable:
        return None
    data = variable.encode_raw(variable.value)
    layout = {1: "<B", 2: "<H", 4: "<I"}.get(len(data))
    if layout is None:
        return None
    return SdoWrite(variable.index, variable.subindex, layout, struct.unpack(layout, data)[0])


def interpolation_period(rate: float) -> tuple[int, int]:
    """Object 60C2 for a rate [Hz]: period = value * 10**exponent seconds, value in 1 ... 255.

    Raises:
        BadInput: the period has no such representation.
    """
    for exponent in range(-3, -7, -1):
        value = 10.0**-exponent / rate
        if 0.5 < value < 255.5 and abs(value - round(value)) < 1e-6 * value:
            return round(value), exponent
    raise BadInput(
        f"a period of 1/{rate:g} s cannot be written to object 60C2 (1 ... 255 times a power of ten); "
        "choose a rate such as 200, 250, 400, 500 or 1000 Hz"
    )
