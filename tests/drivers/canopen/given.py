"""Dictionaries of drives that differ from the standard in a few objects."""

from collections.abc import Mapping

from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from drivers.canopen.sdo import SdoWrite
from drivers.eds import Address
from recordings.rig import Drive


def dictionary(
    drive: Drive, values: Mapping[Address, bytes | int] | None = None, absent: tuple[int | Address, ...] = ()
) -> DriveDictionary:
    """The standard one with these values (integers: of 4 bytes), without the objects or indices that are absent."""
    encoded = {a: v if isinstance(v, bytes) else v.to_bytes(4, "little") for a, v in (values or {}).items()}
    data = {**standard_dictionary(drive).data, **encoded}
    return DriveDictionary(drive, {a: v for a, v in data.items() if a not in absent and a[0] not in absent})


def values_of(writes: list[SdoWrite]) -> dict[Address, int]:
    """The last value that is written to each object."""
    return {(write.index, write.sub): write.value for write in writes}
