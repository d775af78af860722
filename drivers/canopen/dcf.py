"""Values of a drive's DCF (CiA 306), as SDO downloads."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from drivers.canopen.dictionary import MAPPING
from drivers.canopen.node_axes import of_axis
from drivers.canopen.pdo import INVALID
from drivers.canopen.requirements import PDOS
from drivers.canopen.sdo import SdoWrite
from drivers.eds import Address, ObjectDescription, load_dictionary
from recordings.errors import BadInput
from recordings.rig import Drive

_COMMANDS = {0x6040, 0x6060, 0x607A, 0x60C1, 0x60FE, 0x60FF, 0x6071, 0x6042, 0x60B0, 0x60B1, 0x60B2}
"""Controlword, mode, targets and outputs: they act at once, and are the cycle's business."""
_ACTIONS = {0x1010, 0x1011, 0x1023, 0x1024, 0x1025, 0x1F50, 0x1F51}
"""Store, restore, operating system commands, program download."""
_LAYOUTS = {1: "<B", 2: "<H", 4: "<I", 8: "<Q"}


def configuration(drive: Drive) -> list[SdoWrite]:
    """Parameter values of the drive's DCF: objects by address, then each PDO in the order that CiA 301 requires.

    PDOs are left switched off; the set-up enables those that it needs.

    Raises:
        BadInput: the file is missing, is no DCF, or holds no values (an EDS).
    """
    if drive.dcf is None:
        return []
    dictionary = load_dictionary(Path(drive.dcf), drive.node_id)
    if not dictionary.has_parameters:
        raise BadInput(
            f"DCF {drive.dcf} of node {drive.node_id}: values (ParameterValue) expected, none found; it is an EDS, "
            "which describes a type of drive and configures none: remove dcf or name a DCF"
        )
    writes = [write for item in of_axis(dictionary, drive.axis).items() if (write := _write(*item)) is not None]
    return [*(write for write in writes if write.index not in PDOS), *_pdo_writes(writes)]


def _write(address: Address, item: ObjectDescription) -> SdoWrite | None:
    if address[0] in _COMMANDS | _ACTIONS or not (item.is_parameter and item.is_writable and item.is_readable):
        return None
    layout = _LAYOUTS.get(len(item.value or b""))
    if item.value is None or layout is None:
        return None
    # What can be mapped is process data, which the drive may change before it is read back.
    return SdoWrite(*address, layout, int.from_bytes(item.value, "little"), check=not item.mappable)


def _pdo_writes(writes: Iterable[SdoWrite]) -> Iterator[SdoWrite]:
    values = {(write.index, write.sub): write for write in writes if write.index in PDOS}
    for parameters in sorted({index for index, _ in values if not index & MAPPING}):
        mapping = parameters + MAPPING
        cob_id = values.get((parameters, 1))
        if cob_id is None:
            continue
        yield SdoWrite(parameters, 1, "<I", cob_id.value | INVALID, check=False)
        yield from (values[a] for a in sorted(values) if a[0] == parameters and a[1] > 1)
        entries = [values[a] for a in sorted(values) if a[0] == mapping and a[1] > 0]
        count = values.get((mapping, 0))
        if count is None:
            continue
        yield SdoWrite(mapping, 0, "<B", 0, check=False)
        yield from entries[: count.value]
        yield count
