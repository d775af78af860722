"""Rewriting a truncated or damaged MCAP file: its intact chunks, a new end and a new index."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema

from recordings import container
from recordings.blocks import SampleTable, encode
from recordings.chunk import MESSAGE_HEAD, RECORD_HEAD, located, rows, unpacked
from recordings.container_writer import ContainerWriter, Packed
from recordings.errors import BadInput
from recordings.files import new_file


@dataclass(frozen=True)
class RewriteSummary:
    """Amount of data recovered and lost in a rewritten file."""

    messages: int
    duration: float
    """Time from the first message to the last [s]."""
    damaged_chunks: int
    """Number of chunks left out because they are damaged."""
    bytes_behind: int
    """Number of bytes at the end of the old file that form no complete record."""


def rewrite(source: Path, out: Path, run: Mapping[str, str], samples: SampleTable | None = None) -> RewriteSummary:
    """Copy everything intact in `source` to the new file `out`, followed by `samples` and a final record `run`.

    Raises:
        BadInput: `source` is missing, not MCAP, or contains nothing intact; `out` exists or cannot be created.
        OSError: `out` cannot be written; the partial file is removed.
    """
    with container.open_records(source) as stream, new_file(out) as target:
        rewriter = _Rewriter(source, ContainerWriter(target))
        summary = rewriter.copy_intact(stream)
        if samples is not None:
            rewriter.add(samples)
        rewriter.writer.metadata("run", run)
        rewriter.writer.finish()
    return summary


class _Rewriter:
    def __init__(self, source: Path, writer: ContainerWriter) -> None:
        self._source = source
        self.writer = writer
        self._channels: dict[str, int] = {}
        self._messages = 0
        self._damaged = 0
        self._first, self._last = 2**63, 0

    def copy_intact(self, stream: container.RecordStream) -> RewriteSummary:
        end = len(container.MAGIC)
        for opcode, offset, body in stream.records():
            if not Opcode.HEADER <= opcode <= Opcode.DATA_END:
                break  # not a record
            end = offset + RECORD_HEAD + len(body)
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                break
            self._copy(opcode, body)
        if not self._messages:
            raise BadInput(
                f"recording {self._source} holds no intact data, so there is nothing to recover; record again"
            )
        # In a complete file, the data are followed by the old index, which is not lost data.
        behind = 0 if stream.complete else stream.end - end
        return RewriteSummary(self._messages, (self._last - self._first) / 1e9, self._damaged, behind)

    def add(self, samples: SampleTable) -> None:
        for packed in encode(samples, self._channels):
            self.writer.chunk(packed)

    def _copy(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.CHUNK:
            try:
                packed = self._repack(container.decode(Chunk.read, body))
            except container.DECODE_ERRORS:
                self._damaged += 1
                return
            self.writer.chunk(packed)
        elif opcode == Opcode.METADATA:
            record = container.decode(Metadata.read, body)
            self.writer.metadata(record.name, record.metadata)
        else:
            self._describe(opcode, body)

    def _repack(self, chunk: Chunk) -> Packed:
        data = unpacked(chunk)
        messages, other_records = located(data)
        for opcode, body in other_records:
            self._describe(opcode, body)
        index: dict[int, list[np.ndarray]] = {}
        for (channel, length), offsets in messages.items():
            heads = rows(data, length, offsets)[:, : MESSAGE_HEAD.itemsize]
            log = heads.copy().view(MESSAGE_HEAD)["log"]
            index.setdefault(channel, []).append(np.column_stack([log, np.array(offsets, np.uint64)]))
            self._messages += len(offsets)
            self._first = min(self._first, int(log.min()))
            self._last = max(self._last, int(log.max()))
        return Packed(chunk, {channel: np.concatenate(entries) for channel, entries in index.items()})

    def _describe(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            self.writer.describe([container.decode(Schema.read, body)], [])
        elif opcode == Opcode.CHANNEL:
            channel = container.decode(Channel.read, body)
            self._channels[channel.topic] = channel.id
            self.writer.describe([], [channel])
