"""Making a whole MCAP file of one that is cut off or damaged: its intact chunks, a new end and a new index."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Metadata, Schema

from recordings import container
from recordings.blocks import SampleTable, encode
from recordings.container_writer import ContainerWriter, Packed, create
from recordings.errors import BadInput


@dataclass(frozen=True)
class RewriteSummary:
    """What a rewritten file holds of the one before."""

    messages: int
    duration: float
    """Between the first message and the last [s]."""
    damaged_chunks: int
    """Left out."""
    bytes_behind: int
    """Bytes at the end of the old file that make up no whole record."""


def rewrite(source: Path, out: Path, run: Mapping[str, str], samples: SampleTable | None = None) -> RewriteSummary:
    """Copy everything intact in `source` to the new file `out`, with `samples` and a last record `run` behind it.

    Raises:
        BadInput: `source` is missing, no MCAP file, or holds nothing intact; `out` exists or cannot be created.
        OSError: `out` cannot be written; nothing of it is left.
    """
    data = container.contents(source)
    with create(out) as stream:
        try:
            copy = _Copy(source, ContainerWriter(stream))
            kept = copy.everything(data)
            if samples is not None:
                copy.add(samples)
            copy.writer.metadata("run", run)
            copy.writer.finish()
        except BaseException:
            out.unlink()
            raise
    return kept


class _Copy:
    def __init__(self, source: Path, writer: ContainerWriter) -> None:
        self._source = source
        self.writer = writer
        self._channels: dict[str, int] = {}
        self._messages = 0
        self._damaged = 0
        self._first, self._last = 2**63, 0

    def everything(self, data: bytes) -> RewriteSummary:
        end = len(container.MAGIC)
        for opcode, offset, body in container.records(data):
            if not Opcode.HEADER <= opcode <= Opcode.DATA_END:
                break  # bytes that are no records
            end = offset + container.RECORD_HEAD + len(body)
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                break
            self._copy(opcode, body)
        if not self._messages:
            raise BadInput(
                f"recording {self._source} holds no intact data, so there is nothing to recover; record again"
            )
        # What follows the data of a whole file is its old index.
        behind = 0 if data.endswith(container.MAGIC) else len(data) - end
        return RewriteSummary(self._messages, (self._last - self._first) / 1e9, self._damaged, behind)

    def add(self, samples: SampleTable) -> None:
        for packed in encode(samples, self._channels):
            self.writer.chunk(packed)

    def _copy(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.CHUNK:
            try:
                packed = self._packed(container.decode(Chunk.read, body))
            except container.NONSENSE:
                self._damaged += 1
                return
            self.writer.chunk(packed)
        elif opcode == Opcode.METADATA:
            record = container.decode(Metadata.read, body)
            self.writer.metadata(record.name, record.metadata)
        else:
            self._describe(opcode, body)

    def _packed(self, chunk: Chunk) -> Packed:
        data = container.unpacked(chunk)
        messages, others = container.located(data)
        for opcode, body in others:
            self._describe(opcode, body)
        index: dict[int, list[np.ndarray]] = {}
        for (channel, length), offsets in messages.items():
            log = container.rows(data, length, offsets)[:, 15:23].copy().view("<u8")
            index.setdefault(channel, []).append(np.column_stack([log, np.array(offsets, np.uint64)]))
            self._messages += len(offsets)
            self._first = min(self._first, int(log.min()))
            self._last = max(self._last, int(log.max()))
        return Packed(chunk, {channel: np.concatenate(parts) for channel, parts in index.items()})

    def _describe(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            self.writer.describe([container.decode(Schema.read, body)], [])
        elif opcode == Opcode.CHANNEL:
            channel = container.decode(Channel.read, body)
            self._channels[channel.topic] = channel.id
            self.writer.describe([], [channel])
