"""Reading MCAP files chunk by chunk, complete or truncated.

The mcap library decodes the few descriptive records. What is done with messages, thousands per chunk, stands in
`chunk`.
"""

import os
import struct
import zlib
from collections.abc import Callable, Collection, Iterator, Sequence
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
from numpy.typing import NDArray

from recordings.cdr import Field, Layout, parse_schema
from recordings.chunk import MESSAGE_HEAD, RECORD, RECORD_HEAD, located, message_record, rows, unpacked
from recordings.errors import BadInput, ForeignFile, file_errors
from recordings.kinds import kind_of
from recordings.limits import Allowance

MAGIC = b"\x89MCAP0\r\n"

_HEAD = 4096
"""Number of bytes that tell the kind of a file."""
_BLOCK = 1 << 20
"""Block size of the search for the end of the data [bytes]."""
# Exceptions that the libraries raise on damaged bytes.
DECODE_ERRORS = (McapError, zstandard.ZstdError, struct.error, ValueError, LookupError, OverflowError, MemoryError)

Batch = np.ndarray[Any, np.dtype[Any]]
"""Message records of one topic and one length, with the fields of `message_record`; condensed ones only some."""

T = TypeVar("T")


@dataclass
class Container:
    """The contents of one MCAP file."""

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Metadata records by name; records with the same name are merged, later values win."""
    fields: dict[str, tuple[Field, ...]] = field(default_factory=dict)
    """Message fields by topic."""
    batches: dict[str, list[Batch]] = field(default_factory=dict)
    """Messages by topic, one batch per chunk and message length."""
    unpacked: int = 0
    """Size of the chunks that were read [bytes]."""
    cut_off: bool = True
    """True where the file ends before its footer."""


def _unchanged(batch: Batch) -> Batch:
    return batch


def load(
    path: Path,
    topics: Collection[str],
    condense: Callable[[Batch], Batch] = _unchanged,
    most: int | None = None,
) -> Container:
    """Read the messages of `topics` and all metadata; from a truncated file, everything intact.

    Args:
        condense: reduces each batch, because all messages of a long recording may not fit into memory.
        most: number of bytes to read, as if the file were truncated there.

    Raises:
        BadInput: the file is missing, not MCAP, or damaged.
    """
    loader = RecordLoader(path, topics, condense)
    with open_records(path, most) as stream:
        return loader.load(stream)


@contextmanager
def open_records(path: Path, most: int | None = None) -> Iterator["RecordStream"]:
    """Open an MCAP file, or its first `most` bytes.

    Raises:
        BadInput: the file is missing, is not MCAP, or cannot be read, now or later.
    """
    with file_errors(f"recording {path}"):
        try:
            file = path.open("rb")
        except IsADirectoryError:
            raise ForeignFile(f"recording {path}: a file expected, a folder found; name a file in it", path) from None
    with file:
        stream = RecordStream(path, file, most)
        magic = stream.read(0, len(MAGIC))
        if not magic:
            raise BadInput(f"recording {path} is empty; an MCAP file expected, record again")
        if magic != MAGIC:
            kind = kind_of(path, stream.read(0, _HEAD))
            raise ForeignFile(f"{path} is not an MCAP file{f', but {kind[0]}' if kind else ''}", path)
        yield stream


class RecordStream:
    """A file, or its first `most` bytes, read record by record, because a long recording may not fit into memory."""

    def __init__(self, path: Path, file: BinaryIO, most: int | None) -> None:
        self._path, self._file = path, file
        with file_errors(f"recording {path}"):
            size = file.seek(0, os.SEEK_END)
        self.end = size if most is None else min(most, size)
        """Number of bytes that were written."""
        self.complete = self.end > len(MAGIC) and self.read(self.end - len(MAGIC), self.end) == MAGIC
        """Whether the data end with the MCAP magic, as in a complete file."""
        # After a power failure the file may end in zero bytes that were never written.
        while not self.complete and self.end and not self.read(self.end - 1, self.end).strip(b"\0"):
            before = max(0, self.end - _BLOCK)
            self.end = before + len(self.read(before, self.end).rstrip(b"\0"))
        self.checksum = zlib.crc32(MAGIC)
        """CRC-32 of everything before the last record returned."""

    def records(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield opcode, offset and body of every complete top-level record."""
        for head, offset, end in self._heads():
            body = self.read(offset + RECORD_HEAD, end)
            yield head[0], offset, body
            self.checksum = zlib.crc32(body, zlib.crc32(head, self.checksum))

    def metadata_names(self) -> Iterator[str]:
        """Yield the names of the top-level metadata records; nothing else is read, and messages outside of chunks end
        the search."""
        for head, offset, end in self._heads():
            if head[0] == Opcode.MESSAGE:
                return
            if head[0] == Opcode.METADATA:
                yield decode(Metadata.read, self.read(offset + RECORD_HEAD, end)).name

    def _heads(self) -> Iterator[tuple[bytes, int, int]]:
        """Yield the head, its offset, and the end of every complete top-level record."""
        offset = len(MAGIC)
        while offset + RECORD_HEAD <= self.end:
            head = self.read(offset, offset + RECORD_HEAD)
            end = offset + RECORD_HEAD + RECORD.unpack(head)[1]
            if end > self.end:
                return
            yield head, offset, end
            offset = end

    def read(self, start: int, end: int) -> bytes:
        """Read the bytes from `start` to `end`."""
        with file_errors(f"recording {self._path}"):
            self._file.seek(start)
            return self._file.read(max(0, end - start))


class RecordLoader:
    """Decodes the records of a file: all of them, or one after the other while the file is written."""

    def __init__(self, path: Path, topics: Collection[str], condense: Callable[[Batch], Batch] = _unchanged) -> None:
        self.container = Container(path)
        self._topics = topics
        self._condense = condense
        self._allowance = Allowance()
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, str] = {}
        self._layouts: dict[tuple[str, int], Layout] = {}
        """The last one by topic and message length."""

    def take(self, opcode: int, body: bytes) -> None:
        """Decode the next record of a file that is still written.

        Raises:
            BadInput: the record is damaged.
        """
        self._allowance = Allowance()  # of a chunk: what was taken from those before is used up
        with self._decoding():
            if opcode == Opcode.CHUNK:
                self._load_chunk(body, ())
            else:
                self._describe(opcode, body)

    def load(self, stream: RecordStream) -> Container:
        """Decode all records of `stream`.

        Raises:
            BadInput: the file is damaged.
        """
        with self._decoding():
            self._load_records(stream)
        return self.container

    @contextmanager
    def _decoding(self) -> Iterator[None]:
        try:
            yield
        except BadInput:
            raise
        except DECODE_ERRORS as error:
            of_bytes = isinstance(error, UnicodeError | struct.error)
            reason = "a record holds something else than it says" if of_bytes else str(error) or type(error).__name__
            raise BadInput(
                f"recording {self.container.path} is damaged: {reason}; restore it from a copy, save what is intact "
                "with `daq recover`, or record again"
            ) from None

    def _load_records(self, stream: RecordStream) -> None:
        chunk: bytes | None = None
        index: list[bytes] = []
        for opcode, offset, body in stream.records():
            if opcode == Opcode.MESSAGE_INDEX:
                index.append(body)
                continue
            self._load_chunk(chunk, index)
            chunk, index = None, []
            if opcode == Opcode.CHUNK:
                chunk = body  # its index follows
            elif opcode == Opcode.DATA_END:
                _check_crc(body, stream.checksum)
            elif opcode == Opcode.FOOTER:
                summary_start = int.from_bytes(body[:8], "little")
                _check_crc(body[16:], zlib.crc32(stream.read(summary_start, offset + RECORD_HEAD + 16)))
                self.container.cut_off = False
            else:
                self._describe(opcode, body)
        self._load_chunk(chunk, index)
        if self.container.cut_off and stream.complete:
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
        elif opcode == Opcode.METADATA:
            record = decode(Metadata.read, body)
            self.container.metadata.setdefault(record.name, {}).update(record.metadata)

    def _fields(self, channel: Channel) -> tuple[Field, ...]:
        schema = self._schemas[channel.schema_id]
        encodings = channel.message_encoding, schema.encoding
        try:
            if encodings == ("cdr", "ros2msg"):
                return parse_schema(schema.data.decode())
            reason = f"encodings cdr and ros2msg expected, {' and '.join(encodings)} found"
        except ValueError as error:
            reason = str(error)
        raise ForeignFile(
            f"{self.container.path} is not a recording of this program: {channel.topic}: {reason}",
            self.container.path,
        )

    def _load_chunk(self, chunk: bytes | None, index: Sequence[bytes]) -> None:
        if chunk is None:
            return
        data = unpacked(decode(Chunk.read, chunk), self._allowance)
        self.container.unpacked += len(data)
        messages, other_records = located(data, index)
        for opcode, body in other_records:
            self._describe(opcode, body)
        for (channel, length), offsets in messages.items():
            topic = self._channels.get(channel)
            if topic in self.container.fields:
                records = rows(data, length, offsets)
                batches = self.container.batches.setdefault(topic, [])
                batches.extend(map(self._condense, self._batches(topic, records)))

    def _batches(self, topic: str, rows: NDArray[np.uint8]) -> Iterator[Batch]:
        """View Message records of one length, (n, record size), as messages; several batches only if strings vary."""
        while len(rows):
            layout = self._layout(topic, rows[0, MESSAGE_HEAD.itemsize :])
            batch = rows.view(message_record(layout))[:, 0]
            fits = layout.fits(batch["message"])
            yield batch if fits.all() else batch[fits]
            rows = rows[~fits]

    def _layout(self, topic: str, message: NDArray[np.uint8]) -> Layout:
        """Layout of a `message`: mostly that of the one before, which takes less time to check than to derive."""
        key = topic, len(message)
        known = self._layouts.get(key)
        if known is None or not known.fits(message.view(known.dtype)).all():
            self._layouts[key] = known = Layout.of(self.container.fields[topic], message.tobytes())
        return known


def decode(read: Callable[[ReadDataStream], T], body: bytes) -> T:
    """Decode the record in `body` with the library's `read`."""
    return read(ReadDataStream(BytesIO(body)))


def _check_crc(expected: bytes, actual: int) -> None:
    crc = int.from_bytes(expected[:4], "little")
    if crc not in (0, actual):  # 0: written without a checksum
        raise ValueError("its checksum does not match its contents")
