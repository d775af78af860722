"""Configuration of a CiA 402 drive: the objects to write before it moves, by the table of requirements."""

import struct

from drivers.canopen import pdo
from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.requirements import TABLE, WATCHDOGS
from drivers.canopen.sdo import SdoWrite
from recordings.errors import BadInput
from recordings.rig import Rig


def own_writes(rig: Rig, dictionary: DriveDictionary) -> list[SdoWrite]:
    """The SDO downloads that configure one drive, in order, after those of its DCF.

    Raises:
        BadInput: the rate or a limit does not fit its object, or the drive has too few PDOs.
    """
    return [*object_writes(rig, dictionary), *pdo.pdo_writes(dictionary)]


def object_writes(rig: Rig, dictionary: DriveDictionary) -> list[SdoWrite]:
    """Those of the table, without the PDOs; raises as `own_writes`."""
    others = [row for way, rows in WATCHDOGS.items() if way != dictionary.watchdog for row in rows]
    writes = [
        SdoWrite(*row.address, dictionary.layout(row.address, row.layout), value)
        for row in TABLE
        if row not in others and (value := row.wanted(rig, dictionary)) is not None and not dictionary.lack(row)
        # What the rig file accepts as missing stays as it is where the drive's file excludes the value.
        if row.role != "safety" or not dictionary.refuses(row.address, value)
    ]
    for write in writes:
        try:
            struct.pack(write.layout, write.value)
        except struct.error:
            raise BadInput(
                f"{dictionary.drive.address}: {write.value:.6g} does not fit object "
                f"{write.index:04X}:{write.sub:02X}; check counts_per_turn, gear, zero_offset, units and the limits "
                "in the rig file"
            ) from None
    return writes


def watchdog_off(dictionary: DriveDictionary) -> list[SdoWrite]:
    """The SDO downloads that make a drive expect no master any more; its own heartbeat goes on."""
    rows = WATCHDOGS.get(dictionary.watchdog or "", ())
    return [SdoWrite(*row.address, dictionary.layout(row.address, row.layout), 0) for row in reversed(rows)]
