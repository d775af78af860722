"""Writing MCAP files chunk by chunk: chunks copied unchanged, or encoded from arrays of messages.

The mcap library writes message by message, which suits a live run but is slow for an hour of existing samples.
"""

import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from recordings.container import MAGIC, Batch

PROFILE = "ros2"
LIBRARY = "delta-workbench"
"""Name of the writing program in the file header."""

Index = Mapping[int, NDArray[np.uint64]]
"""Message index of a chunk by channel: (m, 2) log time [ns] and offset in the unpacked chunk [bytes]."""


@dataclass(frozen=True)
class Packed:
    """A chunk and its message index."""

    chunk: Chunk
    index: Index


def pack(batches: Iterable[Batch]) -> Packed:
    """Compress message records (see `chunk.message_record`), one channel in each of `batches`, into a chunk."""
    parts: dict[int, list[NDArray[np.uint64]]] = defaultdict(list)
    data = b""
    for batch in batches:
        offsets = len(data) + batch.itemsize * np.arange(len(batch), dtype=np.uint64)
        parts[int(batch["channel"][0])].append(np.column_stack([batch["log"], offsets]))
        data += batch.tobytes()
    return packed(data, {channel: np.concatenate(entries) for channel, entries in parts.items()})


def packed(data: bytes, index: Index) -> Packed:
    """Compress records, among them the messages of `index`, into a chunk."""
    times = np.concatenate([entries[:, 0] for entries in index.values()])
    chunk = Chunk(
        compression="zstd",
        data=zstandard.compress(data),
        message_start_time=int(times.min()),
        message_end_time=int(times.max()),
        uncompressed_crc=zlib.crc32(data),
        uncompressed_size=len(data),
    )
    return Packed(chunk, index)


class ContainerWriter:
    """Writes one MCAP file to `stream`, which stays open; the file is complete only after `finish`."""

    def __init__(self, stream: BinaryIO, header: Header | None = None) -> None:
        """Write the magic and the header."""
        self._stream = stream
        self._position = 0
        self._crc = 0
        self._described: dict[tuple[type, int], Schema | Channel] = {}
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: Counter[int] = Counter()
        self._write(MAGIC)
        self._record(header or Header(PROFILE, LIBRARY))

    def describe(self, *descriptions: Schema | Channel) -> None:
        """Write schemas and channels; known ones are skipped."""
        for each in descriptions:
            if (type(each), each.id) not in self._described:
                self._described[type(each), each.id] = each
                self._record(each)

    def metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write one metadata record."""
        offset, length = self._record(Metadata(name=name, metadata=dict(values)))
        self._metadata.append(MetadataIndex(offset=offset, length=length, name=name))

    def chunk(self, packed: Packed) -> None:
        """Write one chunk and its indexes; its channels must be described before."""
        chunk, index = packed.chunk, packed.index
        start, length = self._record(chunk)
        offsets = {}
        for channel, entries in index.items():
            offsets[channel], _ = self._record(MessageIndex(channel, entries.tolist()))
            self._counts[channel] += len(entries)
        self._chunks.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                message_end_time=chunk.message_end_time,
                message_index_length=self._position - start - length,
                message_index_offsets=offsets,
                message_start_time=chunk.message_start_time,
                uncompressed_size=chunk.uncompressed_size,
            )
        )

    def finish(self) -> None:
        """Write the summary and the footer."""
        self._record(DataEnd(self._crc))
        start = self._position
        summary: Any = RecordBuilder()  # partly without annotations
        offsets = []
        for opcode, records in self._summary():
            first = summary.count
            for record in records:
                record.write(summary)
            offsets.append(SummaryOffset(opcode, start + first, summary.count - first))
        offsets_start = start + summary.count
        for offset in offsets:
            offset.write(summary)
        # The checksum covers the summary and the footer up to the checksum.
        Footer(start, offsets_start, 0).write(summary)
        covered: bytes = summary.end()[:-4]
        self._write(covered + zlib.crc32(covered).to_bytes(4, "little") + MAGIC)

    def _summary(self) -> Iterable[tuple[Opcode, list[Any]]]:
        schemas, channels = (
            [each for (kind, _), each in self._described.items() if kind is wanted] for wanted in (Schema, Channel)
        )
        filled = [chunk for chunk in self._chunks if chunk.message_index_offsets]
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(channels),
            channel_message_counts=defaultdict(int, self._counts),
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((chunk.message_end_time for chunk in filled), default=0),
            message_start_time=min((chunk.message_start_time for chunk in filled), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(schemas),
        )
        yield Opcode.SCHEMA, schemas
        yield Opcode.CHANNEL, channels
        yield Opcode.STATISTICS, [statistics]
        yield Opcode.CHUNK_INDEX, self._chunks
        yield Opcode.METADATA_INDEX, self._metadata

    def _record(self, record: McapRecord) -> tuple[int, int]:
        builder: Any = RecordBuilder()
        record.write(builder)
        return self._write(builder.end())

    def _write(self, data: bytes) -> tuple[int, int]:
        """Write `data`; return its offset and length [bytes]."""
        offset = self._position
        self._stream.write(data)
        self._crc = zlib.crc32(data, self._crc)
        self._position += len(data)
        return offset, len(data)
