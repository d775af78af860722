"""Object dictionaries of drives in EDS and DCF files (CiA 306), as their makers write them.

An object is what has a section [6040] or [1018sub1]. Lists and counts of objects, and fields that nothing needs, may
say what they like; where a field that an object needs is wrong, the error names its section, key and line.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from canopen.objectdictionary import ODVariable, datatypes

from drivers.eds_sections import Section, Sections, divide
from recordings.errors import BadInput, printable
from recordings.limits import bounded_content

Address = tuple[int, int]
"""Index and sub-index of an object."""

_LARGEST_FILE = 5_000_000
"""Size limit [bytes]."""
_MOST_ENTRIES = 254
"""Sub-indexes of an object."""
_DOMAIN, _VAR = 2, 7
_OBJECT_TYPES = (0, _DOMAIN, 5, 6, _VAR, 8, 9)
_LAST_TYPE = 0xFFF
"""Last index of a data type; those of objects follow."""
_ACCESS = ("ro", "wo", "rw", "rwr", "rww", "const")
_BIT_RATES = (10, 20, 50, 125, 250, 500, 800, 1000)
_NO = ("", "no", "false")
"""What is left of a field that denies something without its zeros."""
_NO_SECTION = Section("", 0, {})


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
    def is_limited(self) -> bool:
        """Whether it takes less than its type can hold."""
        limits = (self.low, -(1 << 64)), (self.high, 1 << 64)
        return any(limit is not None and self.encode(limit) != self.encode(extreme) for limit, extreme in limits)

    @property
    def span(self) -> str:
        """Its limits, as text."""
        low, high = ("..." if limit is None else f"{limit}" for limit in (self.low, self.high))
        return f"{low} alone" if low == high else f"{low} to {high}"

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
        BadInput: the file is missing, is no EDS or DCF, or says wrongly what an object needs.
    """
    text = _text(path)
    try:
        dictionary = _parse(text, node_id)
    except ValueError as error:
        raise BadInput(f"{path}, {printable(str(error))}; correct the file") from None
    if not any(index > _LAST_TYPE for index in dictionary.indices):
        raise BadInput(f"{path}: an EDS or DCF file (CiA 306) expected, no object in it; check the file")
    return dictionary if dictionary.name else replace(dictionary, name=path.stem)


@lru_cache(maxsize=16)
def _parse(text: str, node_id: int) -> Dictionary:
    """The dictionary in the text of a file, kept because drives are often of one type."""
    sections = divide(text)
    entries = dict(sorted(_entries(sections, node_id), key=lambda entry: entry[0]))
    # Some tools write 0 and 0 for no limits; then defaults lie outside.
    unlimited = {address: item for address, item in entries.items() if (item.low, item.high) == (0, 0)}
    if any(any(item.value or b"") for item in unlimited.values()):
        entries |= {address: replace(item, low=None, high=None) for address, item in unlimited.items()}
    device = sections.get("deviceinfo", _NO_SECTION)
    rates = [1000 * rate for rate in _BIT_RATES if device.text(f"BaudRate_{rate}").lower().strip("0x") not in _NO]
    return Dictionary(entries, device.text("ProductName"), frozenset(index for index, _ in entries), frozenset(rates))


def _text(path: Path) -> str:
    content = bounded_content(path, "EDS or DCF", _LARGEST_FILE)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _entries(sections: Sections, node_id: int) -> Iterator[tuple[Address, ObjectDescription]]:
    dummies = sections.get("dummyusage", _NO_SECTION)
    for number in range(datatypes.BOOLEAN, datatypes.UNSIGNED32 + 1):
        if dummies.text(name := f"Dummy{number:04}").lower().strip("0x") not in _NO:
            yield (number, 0), ObjectDescription(number, "const", None, name=name)
    objects = {key: section for key, section in sections.items() if isinstance(key, tuple)}
    divided = {index for index, sub in objects if sub is not None}
    for (index, sub), section in objects.items():
        if (kind := section.number("ObjectType", f"{_VAR}")) not in _OBJECT_TYPES:
            raise section.wrong("ObjectType", "7 (VAR), 8 (ARRAY), 9 (RECORD) or 2 (DOMAIN)")
        if sub is not None:
            yield (index, sub), _description(section, sections, node_id)
        elif count := section.number("CompactSubObj", "0"):
            yield from _compact_entries(index, min(count, _MOST_ENTRIES), section, sections, node_id)
        elif (
            kind in (_VAR, _DOMAIN)
            and (index not in divided or section.text("DataType"))
            and (index, 0) not in objects
        ):
            yield (index, 0), _description(section, sections, node_id)


def _compact_entries(
    index: int, count: int, section: Section, sections: Sections, node_id: int
) -> Iterator[tuple[Address, ObjectDescription]]:
    """Entries of an array whose file gives one description for all, and lists of their values and names."""
    lists = {
        key: sections.get(f"{index:04x}{key.removeprefix('parameter')}", _NO_SECTION).fields
        for key in ("parametervalue", "parametername")
    }
    if (index, 0) not in sections:
        yield (index, 0), ObjectDescription(datatypes.UNSIGNED8, "rw", None, name="Number of entries")
    for sub in range(1, count + 1):
        if (index, sub) not in sections:
            fields = section.fields | {key: own[f"{sub}"] for key, own in lists.items() if f"{sub}" in own}
            yield (index, sub), _description(replace(section, fields=fields), sections, node_id)


def _description(section: Section, sections: Sections, node_id: int) -> ObjectDescription:
    is_domain = section.number("ObjectType", f"{_VAR}") == _DOMAIN  # which needs to say neither type nor access
    data_type = section.number("DataType", f"{datatypes.DOMAIN}" if is_domain else "")
    if not 0 < data_type <= _LAST_TYPE:
        raise section.wrong("DataType", "the index of a data type, such as 0x0007,")
    if data_type > datatypes.UNSIGNED64:
        # CANFestival describes an object with limits by a type of its own; others are bytes as they are.
        own = sections.get((data_type, 1))
        data_type = own.number("DefaultValue") if own else datatypes.DOMAIN
    access = (section.text("AccessType") or "rw" * is_domain).lower()
    if access not in _ACCESS:
        raise section.wrong("AccessType", f"one of {', '.join(_ACCESS)}")
    value, default = (_value(section, key, data_type, node_id) for key in ("ParameterValue", "DefaultValue"))
    low, high = (_limit(section, key, data_type, node_id) for key in ("LowLimit", "HighLimit"))
    return ObjectDescription(
        data_type,
        access,
        _encoded(data_type, default if value is None else value),
        low,
        high,
        section.number("PDOMapping", "0") != 0,
        section.text("ParameterName"),
        value is not None,
    )


def _value(section: Section, key: str, data_type: int, node_id: int) -> Any:
    """Value of a field: of types of numbers a number, of others a text; None where there is none."""
    text, layout = section.text(key), ODVariable.STRUCT_TYPES.get(data_type)
    if layout is None or not text:
        return text if layout is None and key.lower() in section.fields else None
    if data_type in datatypes.FLOAT_TYPES:
        try:
            return float(text)
        except ValueError:
            section.number(key)  # 10.0 may be 0x41200000
            return None
    value, bits = section.number(key, node_id=node_id), 8 * layout.size
    return value - (1 << bits) if data_type in datatypes.SIGNED_TYPES and value >= 1 << bits - 1 else value


def _limit(section: Section, key: str, data_type: int, node_id: int) -> int | None:
    """A limit that is a whole number; None where there is none."""
    value = _value(section, key, data_type, node_id)
    try:
        limit = value if isinstance(value, int) or not section.text(key) else section.number(key)
    except ValueError:
        return None
    layout = ODVariable.STRUCT_TYPES.get(data_type)
    is_wrapped = limit is not None and limit < 0 and layout and data_type not in datatypes.SIGNED_TYPES
    return limit + (1 << 8 * layout.size) if is_wrapped else limit  # as -1 for the largest of an unsigned type


def _encoded(data_type: int, value: Any) -> bytes | None:
    variable = ODVariable("", 0)
    variable.data_type = data_type
    try:
        if value is not None and data_type in (datatypes.OCTET_STRING, datatypes.DOMAIN):
            value = bytes.fromhex(value)
        return None if value is None else bytes(variable.encode_raw(value))
    except (ValueError, TypeError, OverflowError, struct.error):
        return None
