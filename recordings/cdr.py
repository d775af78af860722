"""CDR, the wire format of ROS 2 messages (XCDR1, little endian), for messages whose lengths are known.

With fixed string and sequence lengths, the values of a message type stand at fixed offsets. One precompiled
`struct` then packs a message, and one numpy structured array views many messages.
"""

import re
import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEADER = b"\x00\x01\x00\x00"
"""The encapsulation header: plain CDR, little endian, no options."""

_LENGTH = struct.Struct("<I")
# Type letters shared by `struct` and numpy.
_PRIMITIVES = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
    "builtin_interfaces/Time": "iI",
}
_FIELD = re.compile(r"(?P<type>[\w/]+)(?P<array>\[(?P<bound><=)?(?P<count>\d*)\])?\s+(?P<name>\w+)")


@dataclass(frozen=True)
class Field:
    """One field of a message; nested messages are flattened into dotted names."""

    name: str
    codes: str
    """`struct` letters of one element; "s" for a string."""
    count: int | None
    """1 for a scalar, the length of a fixed array, or None for a sequence, whose length is in the message."""

    @property
    def size(self) -> int:
        """Size of one element [bytes]."""
        return struct.calcsize("<" + self.codes)

    @property
    def alignment(self) -> int:
        """Alignment [bytes]: CDR aligns every primitive to its own size."""
        return struct.calcsize("<" + self.codes[0])


def parse_schema(text: str) -> tuple[Field, ...]:
    """Flatten a ROS 2 message definition, dependencies included, into its fields.

    Raises:
        ValueError: a line is not a field, or its type is neither primitive nor defined in the text.
    """
    main, *dependencies = re.split(r"^={3,}\s*$", text, flags=re.MULTILINE)
    definitions = {}
    for dependency in dependencies:
        title, _, body = dependency.strip().partition("\n")
        definitions[_strip_msg(title.removeprefix("MSG:").strip())] = body
    return tuple(_flatten(main, "", definitions))


def _strip_msg(type_name: str) -> str:
    return type_name.replace("/msg/", "/")


def _flatten(body: str, prefix: str, definitions: Mapping[str, str]) -> Iterable[Field]:
    for line in body.splitlines():
        declaration = line.partition("#")[0].strip()
        if not declaration or "=" in declaration.replace("<=", ""):  # a comment or a constant
            continue
        match = _FIELD.match(declaration)
        if match is None:
            raise ValueError(f"not a field of a message: {declaration!r}")
        type_name, name = _strip_msg(match["type"]), prefix + match["name"]
        count = 1 if match["array"] is None else None if match["bound"] or not match["count"] else int(match["count"])
        if type_name == "string" and count in (1, None):
            yield Field(name, "s", count)
        elif type_name in _PRIMITIVES:
            yield Field(name, _PRIMITIVES[type_name], count)
        elif type_name in definitions and match["array"] is None:
            # Removing the definition on the way down keeps a type from containing itself.
            remaining = {defined: text for defined, text in definitions.items() if defined != type_name}
            yield from _flatten(definitions[type_name], name + ".", remaining)
        else:
            raise ValueError(f"type {match['type']}{match['array'] or ''} of {name!r} is not known")


@dataclass(frozen=True)
class _Slot:
    field: Field
    offset: int
    count: int

    @property
    def end(self) -> int:
        return self.offset + self.count * self.field.size

    @property
    def format(self) -> Any:
        if self.field.codes == "s":
            return f"S{self.count}"
        element = [("sec", "<i4"), ("nanosec", "<u4")] if self.field.codes == "iI" else "<" + self.field.codes
        return element if self.field.count == 1 else (element, (self.count,))


@dataclass(frozen=True)
class _Length:
    name: str
    offset: int
    value: int


class Layout:
    """Offsets of all fields in messages of one type with the same string and sequence lengths."""

    def __init__(self, fields: Iterable[Field], length_at: Callable[[str, int], int]) -> None:
        """Lay out `fields`; `length_at(name, offset)` gives the length of a sequence or of a NUL-terminated string.

        The length field stands at `offset`. Elements of a sequence of strings are named name.0, name.1, ...
        """
        self.slots: list[_Slot] = []
        self.lengths: list[_Length] = []
        self.size = len(HEADER)
        self._length_at = length_at
        for field in fields:
            self._place(field)
        names = ["encapsulation", *(f"length of {length.name}" for length in self.lengths)]
        self.dtype: np.dtype[Any] = np.dtype(
            {
                "names": names + [slot.field.name for slot in self.slots],
                "formats": ["<u4"] * len(names) + [slot.format for slot in self.slots],
                "offsets": [0, *(length.offset for length in self.lengths), *(slot.offset for slot in self.slots)],
                "itemsize": self.size,
            }
        )
        """Dtype of one message; a field of n elements has the shape (n,), a string is bytes."""

    @classmethod
    def of(cls, fields: Iterable[Field], message: bytes) -> "Layout":
        """Derive the layout from one received message.

        Raises:
            ValueError: the message is not little-endian CDR, or its length does not match its contents.
        """
        if message[: len(HEADER)] != HEADER:
            raise ValueError("a message does not begin as CDR in little endian")

        def length_at(_: str, offset: int) -> int:
            length = int.from_bytes(message[offset : offset + _LENGTH.size], "little")
            if offset + _LENGTH.size + length > len(message):
                raise ValueError("a message is shorter than its contents")
            return length

        layout = cls(fields, length_at)
        if layout.size != len(message):
            raise ValueError(f"a message has {len(message)} bytes, its contents {layout.size}")
        return layout

    def fits(self, messages: np.ndarray[Any, np.dtype[Any]]) -> NDArray[np.bool_]:
        """Mask (n,) of the messages, viewed with `dtype`, whose header and lengths agree with this layout."""
        fits: NDArray[np.bool_] = messages["encapsulation"] == int.from_bytes(HEADER, "little")
        for length in self.lengths:
            fits &= messages[f"length of {length.name}"] == length.value
        return fits

    def _place(self, field: Field) -> None:
        count = self._place_length(field.name) if field.count is None or field.codes == "s" else field.count
        if field.codes == "s" and field.count is None:
            for i in range(count):
                self._place(Field(f"{field.name}.{i}", "s", 1))
            return
        # An empty sequence is not aligned.
        offset = self._aligned_offset(field.alignment) if count else self.size
        self.slots.append(_Slot(field, offset, count))
        self.size = self.slots[-1].end

    def _place_length(self, name: str) -> int:
        offset = self._aligned_offset(_LENGTH.size)
        self.lengths.append(_Length(name, offset, self._length_at(name, offset)))
        self.size = offset + _LENGTH.size
        return self.lengths[-1].value

    def _aligned_offset(self, alignment: int) -> int:
        # Alignment is relative to the end of the encapsulation header.
        return self.size + (len(HEADER) - self.size) % alignment


class Encoder:
    """Packs messages of one type whose strings and sequence lengths are constant."""

    def __init__(self, fields: Iterable[Field], texts: Mapping[str, str], lengths: Mapping[str, int]) -> None:
        """Prepare the encoder from every string (`texts`) and every sequence length (`lengths`), by field name."""
        strings = {name: text.encode("utf-8", "replace") + b"\0" for name, text in texts.items()}
        known = {name: len(string) for name, string in strings.items()} | dict(lengths)
        layout = Layout(fields, lambda name, _: known[name])
        template = bytearray(HEADER.ljust(layout.size, b"\0"))
        for length in layout.lengths:
            _LENGTH.pack_into(template, length.offset, length.value)
        for slot in layout.slots:
            if slot.field.codes == "s":
                template[slot.offset : slot.end] = strings[slot.field.name]
        # Values stand between constants: what the template holds before each slot of values, and behind the last.
        codes, values, end = "<", 0, 0
        self._constants: list[tuple[int, bytes]] = []
        for slot in layout.slots:
            if slot.field.codes != "s":
                self._constants.append((values, bytes(template[end : slot.offset])))
                codes += f"{slot.offset - end}s{slot.field.codes * slot.count}"
                values += 1 + len(slot.field.codes) * slot.count
                end = slot.end
        self._constants.append((values, bytes(template[end:])))
        self._struct = struct.Struct(f"{codes}{layout.size - end}s")

    def pack(self, values: list[Any]) -> bytes:
        """Pack one message from its values in order, without strings and lengths; a time is seconds, nanoseconds.

        `values` is modified in place.

        Raises:
            struct.error: the number of values is wrong, or a value is out of range.
        """
        for index, constant in self._constants:
            values.insert(index, constant)
        return self._struct.pack(*values)
