"""Object dictionaries of drives in EDS and DCF files (CiA 306).

canopen parses the file. Its known limitations are mended here: it opens files only in the locale's encoding, leaves a
signed default in hexadecimal unsigned, needs a section of device information, reads one entry of a compact array and
no value, and answers every sub-index of a variable and of an array.
"""

import io
import logging
import struct
import warnings
from collections.abc import Iterator, Mapping
from configparser import Error, RawConfigParser
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from canopen.objectdictionary import ODVariable, datatypes
from canopen.objectdictionary.eds import import_eds

from recordings.errors import BadInput
from recordings.limits import bounded_content

Address = tuple[int, int]
"""Index and sub-index of an object."""

_LARGEST_FILE = 5_000_000
"""Size limit [bytes]."""


_MOST_ENTRIES = 254
"""Sub-indexes of an object."""
_ENTRY_KEYS = ("ParameterName", "DataType", "AccessType", "LowLimit", "HighLimit", "DefaultValue", "PDOMapping")


@dataclass(frozen=True)
class ObjectDescription:
    """One object: its type, access, limits, and its value when the drive is switched on."""

    data_type: int
    access: str
    value: bytes | None
    """ParameterValue of a DCF, else the default value; None: the file gives none."""
    low: int | None = None
    high: int | None = None
    mappable: bool = False
    name: str = ""
    is_parameter: bool = False
    """Whether the value is the ParameterValue of a DCF."""

    @property
    def size(self) -> int | None:
        """Length [bytes]; None where it varies."""
        layout = ODVariable.STRUCT_TYPES.get(self.data_type)
        return None if layout is None else layout.size

    @property
    def is_integer(self) -> bool:
        """Whether the value is an integer."""
        return self.data_type in datatypes.INTEGER_TYPES

    @property
    def is_readable(self) -> bool:
        """Whether SDO may read the object."""
        return "r" in self.access or self.access == "const"

    @property
    def is_writable(self) -> bool:
        """Whether SDO may write the object."""
        return "w" in self.access

    def decode(self, data: bytes) -> int:
        """Integer of the object's bytes."""
        return int.from_bytes(data, "little", signed=self.data_type in datatypes.SIGNED_TYPES)

    def encode(self, value: int) -> bytes:
        """Bytes of an integer; one that does not fit the type becomes the nearest that does."""
        signed = self.data_type in datatypes.SIGNED_TYPES
        bits = 8 * (self.size or 4)
        low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        return min(max(value, low), high).to_bytes(bits // 8, "little", signed=signed)


@dataclass(frozen=True)
class Dictionary(Mapping[Address, ObjectDescription]):
    """All objects of one drive, by address."""

    entries: Mapping[Address, ObjectDescription]
    name: str
    """Product name of the file's device information."""
    indices: frozenset[int]
    bit_rates: frozenset[int] = frozenset()
    """Bit rates of the file's device information [bit/s]."""

    @property
    def has_parameters(self) -> bool:
        """Whether the file is a DCF: it gives values of its own, not only defaults."""
        return any(description.is_parameter for description in self.values())

    def __getitem__(self, address: Address) -> ObjectDescription:
        return self.entries[address]

    def __iter__(self) -> Iterator[Address]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)


def load_dictionary(path: Path, node_id: int) -> Dictionary:
    """Read an EDS or DCF file; `node_id` replaces $NODEID.

    Raises:
        BadInput: the file is missing, or is no EDS or DCF.
    """
    text = _text(path)
    try:
        dictionary = _parse(text, node_id)
    except (Error, KeyError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise BadInput(f"{path}: an EDS or DCF file (CiA 306) expected, {reason}; check the file") from None
    if not any(index >= 0x1000 for index in dictionary.indices):
        raise BadInput(f"{path}: an EDS or DCF file (CiA 306) expected, no object in it; check the file")
    return dictionary if dictionary.name else replace(dictionary, name=path.stem)


@lru_cache(maxsize=16)
def _parse(text: str, node_id: int) -> Dictionary:
    """The dictionary in the text of a file, kept because parsing takes long and drives are often of one type."""
    if "[DeviceInfo]" not in text:
        # canopen warns of its absence through a deprecated function.
        text += "\n[DeviceInfo]\n"
    # canopen logs data types that it does not know and serves their bytes as they are, which is what a drive does.
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():  # it logs by a method that Python has deprecated
        warnings.simplefilter("ignore", DeprecationWarning)
        parsed: Any = import_eds(io.StringIO(text + _compact_entries(text)), node_id)
    entries = dict(_entries(parsed))
    return Dictionary(
        entries,
        parsed.device_information.product_name or "",
        frozenset(index for index, _ in entries),
        frozenset(parsed.device_information.allowed_baudrates),
    )


def _text(path: Path) -> str:
    content = bounded_content(path, "EDS or DCF", _LARGEST_FILE)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _compact_entries(text: str) -> str:
    """Sections of the entries of arrays whose file gives one description for all (CompactSubObj), with the values of
    a DCF."""
    file = RawConfigParser(inline_comment_prefixes=(";",))
    file.read_string(text)
    lines, given = [""], {section.lower() for section in file.sections()}
    for section in file.sections():
        count = min(int(file.get(section, "CompactSubObj", fallback="0"), 0), _MOST_ENTRIES)
        for sub in range(1, count + 1):
            if (entry := f"{section}sub{sub:x}".lower()) not in given:
                value = file.get(f"{section}Value", str(sub), fallback=None)
                keys = {key: file.get(section, key, fallback=None) for key in _ENTRY_KEYS} | {"ParameterValue": value}
                lines += [f"[{entry}]", "ObjectType=0x7", *(f"{key}={keys[key]}" for key in keys if keys[key])]
    return "\n".join(lines)


def _entries(parsed: Any) -> Iterator[tuple[Address, ObjectDescription]]:
    for item in parsed.values():
        for variable in [item] if isinstance(item, ODVariable) else item.values():
            yield (variable.index, variable.subindex), _description(variable)


def _description(variable: Any) -> ObjectDescription:
    value = variable.default if variable.value is None else variable.value
    return ObjectDescription(
        variable.data_type,
        variable.access_type,
        None if value is None else _encoded(variable, value),
        variable.min,
        variable.max,
        variable.pdo_mappable,
        variable.name,
        variable.value is not None,
    )


def _encoded(variable: Any, value: Any) -> bytes | None:
    if variable.data_type in datatypes.SIGNED_TYPES and value >= 1 << len(variable) - 1:
        value -= 1 << len(variable)
    try:
        return bytes(variable.encode_raw(value))
    except (ValueError, TypeError, struct.error):
        return None
