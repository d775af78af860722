"""Reading MCAP files whole, a chunk at a time, be they complete or cut off.

The mcap library decodes the few descriptive records. Messages, thousands per chunk, are only located here; all
messages of a chunk that have one length are then viewed as one numpy array.
"""

import os
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from numpy.typing import NDArray

from recordings.cdr import Field, Layout, parse_schema
from recordings.errors import BadInput

MAGIC = b"\x89MCAP0\r\n"

_RECORD = struct.Struct("<BQ")
RECORD_HEAD = _RECORD.size
"""Bytes of opcode and length in front of every record."""
_BLOCK = 1 << 20
"""Bytes that are looked at together in search of the end."""
_MESSAGE = struct.Struct("<BQH")
_MESSAGE_HEAD = 31
"""Bytes of a Message record before the message itself: opcode, length, channel, sequence, log and publish time."""

# What the libraries raise on bytes that make no sense.
NONSENSE = (McapError, zstandard.ZstdError, struct.error, ValueError, LookupError, OverflowError, MemoryError)

Batch = np.ndarray[Any, np.dtype[Any]]
"""Messages of one topic and one length: `log` [ns] and `message`, whose fields are those of `Layout.dtype`."""

T = TypeVar("T")


@dataclass
class Container:
    """The contents of one MCAP file."""

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Metadata records by name; of several records with one name, later ones add to earlier ones."""
    fields: dict[str, tuple[Field, ...]] = field(default_factory=dict)
    """Topic: the values of its messages."""
    batches: dict[str, list[Batch]] = field(default_factory=dict)
    """Topic: its messages, in as many parts as there are chunks and lengths."""
    cut_off: bool = True
    """Whether the file ends before its footer."""


def _as_it_is(batch: Batch) -> Batch:
    return batch


def load(
    path: Path,
    topics: Collection[str],
    condense: Callable[[Batch], Batch] = _as_it_is,
    most: int | None = None,
) -> Container:
    """Read the messages of `topics` and all metadata. Of a file that is cut off, everything intact.

    Every batch is kept as `condense` returns it: a long recording's messages may not fit into memory as they are.
    most: bytes of the file to look at, as if it were cut off there.

    Raises:
        BadInput: there is no such file, it is not MCAP, or its bytes are damaged.
    """
    loader = _Loader(path, topics, condense)
    with _opened(path) as file:
        loader.take(_Stream(file, most))
    return loader.container


def contents(path: Path, most: int | None = None) -> bytes:
    """The bytes of an MCAP file, or the first `most` of them.

    Raises:
        BadInput: there is no such file, it cannot be read, or is not MCAP.
    """
    with _opened(path) as file:
        data = file.read(-1 if most is None else most)
    return data if data.endswith(MAGIC) else data.rstrip(b"\0")


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """The file at its beginning, which is that of an MCAP file: only then more of it is read.

    Raises:
        BadInput: as `contents`.
    """
    try:
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
            if not magic:
                raise BadInput(f"recording {path} is empty; an MCAP file expected, record again")
            if magic != MAGIC:
                raise BadInput(
                    f"{path} is not an MCAP file: it begins with {magic!r}; bring a table in with daq import"
                )
            file.seek(0)
            yield file
    except FileNotFoundError:
        raise BadInput(f"recording {path} does not exist; check the path") from None
    except IsADirectoryError:
        raise BadInput(f"recording {path}: a file expected, a folder found; name a file in it") from None
    except OSError as error:
        raise BadInput(f"recording {path} cannot be read: {error.strerror}") from None


class _Stream:
    """A file, or its first `most` bytes, record by record: all of a long recording would fill the memory."""

    def __init__(self, file: BinaryIO, most: int | None) -> None:
        self._file = file
        size = file.seek(0, os.SEEK_END)
        self._end = size if most is None else min(most, size)
        self.whole = self._end > len(MAGIC) and self.part(self._end - len(MAGIC), self._end) == MAGIC
        """Whether it ends as a whole file does."""
        # What a power failure cut off may end in zeros that were never written.
        while not self.whole and self._end and not self.part(self._end - 1, self._end).strip(b"\0"):
            before = max(0, self._end - _BLOCK)
            self._end = before + len(self.part(before, self._end).rstrip(b"\0"))
        self.checksum = zlib.crc32(MAGIC)
        """Of all before the record that came last."""

    def records(self) -> Iterator[tuple[int, int, bytes]]:
        """Opcode, offset and body of every top-level record that is there as a whole."""
        offset = len(MAGIC)
        while offset + RECORD_HEAD <= self._end:
            head = self.part(offset, offset + RECORD_HEAD)
            opcode, length = _RECORD.unpack(head)
            start = offset + RECORD_HEAD
            if start + length > self._end:
                return
            body = self.part(start, start + length)
            yield opcode, offset, body
            self.checksum = zlib.crc32(body, zlib.crc32(head, self.checksum))
            offset = start + length

    def part(self, start: int, end: int) -> bytes:
        """Its bytes from `start` to `end`."""
        self._file.seek(start)
        return self._file.read(max(0, end - start))


class _Loader:
    def __init__(self, path: Path, topics: Collection[str], condense: Callable[[Batch], Batch] = _as_it_is) -> None:
        self.container = Container(path)
        self._topics = topics
        self._condense = condense
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, str] = {}

    def take(self, stream: _Stream) -> None:
        try:
            self._take(stream)
        except BadInput:
            raise
        except NONSENSE as error:
            reason = str(error) or type(error).__name__
            raise BadInput(
                f"recording {self.container.path} is damaged: {reason}; restore it from a copy, save what is intact "
                "with `daq recover`, or record again"
            ) from None

    def _take(self, stream: _Stream) -> None:
        for opcode, offset, body in stream.records():
            if opcode == Opcode.METADATA:
                record = decode(Metadata.read, body)
                self.container.metadata.setdefault(record.name, {}).update(record.metadata)
            elif opcode == Opcode.CHUNK:
                self._chunk(unpacked(decode(Chunk.read, body)))
            elif opcode == Opcode.DATA_END:
                _compare_crc(body, stream.checksum)
            elif opcode == Opcode.FOOTER:
                summary_start = int.from_bytes(body[:8], "little")
                _compare_crc(body[16:], zlib.crc32(stream.part(summary_start, offset + RECORD_HEAD + 16)))
                self.container.cut_off = False
            else:
                self._describe(opcode, body)
        if self.container.cut_off and stream.whole:
            raise ValueError("it has an end, but the records before do not lead there")

    def _describe(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            schema = decode(Schema.read, body)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = decode(Channel.read, body)
            self._channels[channel.id] = channel.topic
            if channel.topic in self._topics:
                self.container.fields[channel.topic] = self._fields(channel)

    def _fields(self, channel: Channel) -> tuple[Field, ...]:
        schema = self._schemas[channel.schema_id]
        encodings = channel.message_encoding, schema.encoding
        try:
            if encodings == ("cdr", "ros2msg"):
                return parse_schema(schema.data.decode())
            reason = f"encodings cdr and ros2msg expected, {' and '.join(encodings)} found"
        except ValueError as error:
            reason = str(error)
        raise BadInput(
            f"{self.container.path} is not a recording of this program: {channel.topic}: {reason}; "
            f"record with `daq record`"
        )

    def _chunk(self, data: bytes) -> None:
        messages, others = located(data)
        for opcode, body in others:
            self._describe(opcode, body)
        for (channel, length), offsets in messages.items():
            topic = self._channels.get(channel)
            if topic in self.container.fields:
                records = rows(data, length, offsets)
                batches = self.container.batches.setdefault(topic, [])
                batches.extend(map(self._condense, _batches(self.container.fields[topic], records)))


def unpacked(chunk: Chunk) -> bytes:
    """The records in a chunk. Raises one of `NONSENSE` where its bytes are damaged."""
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data: bytes = stream.read(size)
    return data


def located(data: bytes) -> tuple[dict[tuple[int, int], list[int]], list[tuple[int, bytes]]]:
    """Where the messages stand in an unpacked chunk, by channel and length; opcode and body of all other records."""
    messages: dict[tuple[int, int], list[int]] = defaultdict(list)
    others = []
    offset = 0
    while offset < len(data):
        opcode, length, channel = _MESSAGE.unpack_from(data, offset)
        if opcode == Opcode.MESSAGE:
            messages[channel, length].append(offset)
        else:
            start = offset + _RECORD.size
            others.append((opcode, data[start : start + length]))
        offset += _RECORD.size + length
    return messages, others


def rows(data: bytes, length: int, offsets: list[int]) -> NDArray[np.uint8]:
    """The Message records at `offsets` as (n, record), for messages of one length; log time in bytes 15 to 23."""
    buffer = np.frombuffer(data, np.uint8)
    view: NDArray[np.uint8] = np.lib.stride_tricks.sliding_window_view(buffer, _RECORD.size + length)[offsets]
    return view


def _batches(fields: tuple[Field, ...], rows: NDArray[np.uint8]) -> Iterator[Batch]:
    """View Message records of one length, (n, length), as messages; more than once only where strings vary."""
    while len(rows):
        layout = Layout.of(fields, rows[0, _MESSAGE_HEAD:].tobytes())
        dtype = np.dtype(
            {
                "names": ["log", "message"],
                "formats": ["<u8", layout.dtype],
                "offsets": [15, _MESSAGE_HEAD],
                "itemsize": rows.shape[1],
            }
        )
        batch = rows.view(dtype)[:, 0]
        fits = layout.fits(batch["message"])
        yield batch if fits.all() else batch[fits]
        rows = rows[~fits]


def records(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Opcode, offset and body of every top-level record that is there as a whole."""
    offset = len(MAGIC)
    while offset + _RECORD.size <= len(data):
        opcode, length = _RECORD.unpack_from(data, offset)
        start = offset + _RECORD.size
        if start + length > len(data):
            return
        yield opcode, offset, data[start : start + length]
        offset = start + length


def decode(read: Callable[[ReadDataStream], T], body: bytes) -> T:
    """The record that the library's `read` makes of `body`."""
    return read(ReadDataStream(BytesIO(body)))


def _compare_crc(expected: bytes, actual: int) -> None:
    crc = int.from_bytes(expected[:4], "little")
    if crc not in (0, actual):  # 0: the file was written without
        raise ValueError("its checksum does not match its contents")
