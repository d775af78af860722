"""The intact records of an MCAP file that is damaged or cut off anywhere."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

from recordings.chunk import RECORD, RECORD_HEAD, beginning, unpacked
from recordings.container import DECODE_ERRORS, MAGIC, RecordStream, decode

_BLOCK = 1 << 20
"""Size of the blocks in which a record is searched [bytes]."""
_LARGEST_CHUNK = 1 << 26
"""Size up to which a chunk that was cut off is read [bytes]."""
_CHUNK_HEAD = 40
"""Size of what precedes the data of a chunk, without the name of its compression [bytes]."""
_LENGTH_BYTES = 4
"""Bytes of the length that may differ from 0: no record has more than 4 GB."""
_KINDS: dict[int, Any] = {
    Opcode.HEADER: records.Header,
    Opcode.FOOTER: records.Footer,
    Opcode.SCHEMA: records.Schema,
    Opcode.CHANNEL: records.Channel,
    Opcode.MESSAGE: records.Message,
    Opcode.CHUNK: records.Chunk,
    Opcode.MESSAGE_INDEX: records.MessageIndex,
    Opcode.CHUNK_INDEX: records.ChunkIndex,
    Opcode.ATTACHMENT: records.Attachment,
    Opcode.ATTACHMENT_INDEX: records.AttachmentIndex,
    Opcode.STATISTICS: records.Statistics,
    Opcode.METADATA: records.Metadata,
    Opcode.METADATA_INDEX: records.MetadataIndex,
    Opcode.SUMMARY_OFFSET: records.SummaryOffset,
    Opcode.DATA_END: records.DataEnd,
}


@dataclass(frozen=True)
class Span:
    """Where a record stands."""

    opcode: int
    start: int
    """Offset of its head."""
    end: int


class IntactRecords:
    """Records of `stream` that are whole; behind damage, the next one is searched byte by byte.

    A record counts if the next one begins where it ends; or if it is what its head says, byte by byte, and no other
    one begins inside of it: where bytes are missing, it would reach into the next one.
    """

    def __init__(self, stream: RecordStream) -> None:
        self._stream = stream
        self._end = stream.end - len(MAGIC) * stream.complete
        self.beginning = b""
        """Whole records in the chunk in which the file is cut off; known after `spans`."""
        self.cut = 0
        """Number of bytes that were written of it."""

    @cached_property
    def spans(self) -> list[Span]:
        """All of them, in the order of the file."""
        return list(self._found())

    @property
    def skipped(self) -> int:
        """Number of bytes that belong to no record."""
        return self._end - len(MAGIC) - sum(span.end - span.start for span in self.spans)

    def body(self, span: Span) -> bytes:
        """The content of a record."""
        return self._stream.read(span.start + RECORD_HEAD, span.end)

    def checksum(self, start: int, end: int) -> int:
        """CRC-32 of everything from `start` to `end`."""
        crc = 0
        for first in range(start, end, _BLOCK):
            crc = zlib.crc32(self._stream.read(first, min(first + _BLOCK, end)), crc)
        return crc

    def decoded(self, opcode: int) -> Iterator[tuple[Span, Any]]:
        """Yield the records of one kind with their places; those whose content is damaged are left out."""
        for span in self.spans:
            if span.opcode == opcode:
                try:
                    yield span, decode(_KINDS[opcode].read, self.body(span))
                except DECODE_ERRORS:
                    continue

    def _found(self) -> Iterator[Span]:
        offset = len(MAGIC)
        while offset < self._end:
            span = self._head(offset)
            if span is None and self._is_cut(offset):
                return
            if span is None or not self._is_followed(span):
                other = self._next(offset + 1)
                if span is None or not self._is_whole(span) or (other and other.start < span.end):
                    span = other
            if span is None:
                return
            yield span
            offset = span.end

    def _head(self, offset: int) -> Span | None:
        """The record whose head could stand at `offset`."""
        head = self._stream.read(offset, min(offset + RECORD_HEAD, self._end))
        if len(head) < RECORD_HEAD:
            return None
        opcode, length = RECORD.unpack(head)
        end = offset + RECORD_HEAD + length
        return Span(opcode, offset, end) if opcode in _KINDS and end <= self._end else None

    def _is_cut(self, offset: int) -> bool:
        """Whether the file is cut off in the data of a chunk that begins at `offset`."""
        record = self._stream.read(offset, min(self._end, offset + _LARGEST_CHUNK))
        if self._stream.complete or record[0] != Opcode.CHUNK:
            return False
        try:
            chunk = decode(records.Chunk.read, record[RECORD_HEAD:])
            self.beginning = beginning(chunk)
        except DECODE_ERRORS:
            return False
        self.cut = RECORD_HEAD + _CHUNK_HEAD + len(chunk.compression) + len(chunk.data)
        return offset + self.cut == self._end  # else its length is damaged, and others follow

    def _is_followed(self, span: Span) -> bool:
        return span.end == self._end or self._head(span.end) is not None

    def _is_whole(self, span: Span) -> bool:
        """Whether a record is what its head says: written again, it is the same, and a chunk fits its checksum.

        A message, which stands outside of chunks in no recording of this program, would be anything.
        """
        if span.opcode == Opcode.MESSAGE:
            return False
        builder: Any = RecordBuilder()  # partly without annotations
        body = self.body(span)
        try:
            record = decode(_KINDS[span.opcode].read, body)
            record.write(builder)
            if span.opcode == Opcode.CHUNK:
                unpacked(record)
        except DECODE_ERRORS:
            return False
        return bool(builder.end() == RECORD.pack(span.opcode, len(body)) + body)

    def _next(self, offset: int) -> Span | None:
        """The first whole record at `offset` or behind it."""
        for first in range(offset, self._end, _BLOCK):
            block = np.frombuffer(self._stream.read(first, first + _BLOCK + RECORD_HEAD - 1), np.uint8)
            count = len(block) - RECORD_HEAD + 1
            possible = np.isin(block[: max(count, 0)], list(_KINDS))
            for byte in range(1 + _LENGTH_BYTES, RECORD_HEAD):
                possible &= block[byte : byte + count] == 0
            for start in np.flatnonzero(possible).tolist():
                span = self._head(first + start)
                if span is not None and self._is_whole(span):
                    return span
        return None
