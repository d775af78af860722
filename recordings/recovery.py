"""Rewriting a truncated or damaged MCAP file: its intact chunks, a new end and a new index.

A recording of this program stays one: lost descriptions are replaced, and its run ends. A file of another program
keeps its messages, and what was written of a chunk in which it is cut off.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata, Schema
from pydantic import ValidationError

from recordings import container, schemas
from recordings.blocks import SampleTable, encode, message_types
from recordings.chunk import MESSAGE_HEAD, RECORD, located, rows, unpacked
from recordings.container_writer import LIBRARY, ContainerWriter, Index, Packed, packed
from recordings.errors import BadInput
from recordings.files import new_file
from recordings.intact import IntactRecords, Span
from recordings.metadata import rig_record, run_record, software
from recordings.recording import LOST, Ints, Run
from recordings.rig import Rig

_SAMPLES = "/amplifiers"
"""Topic with one message for each sample, which holds the SYNC counter."""
_LOOSE = 1 << 20
"""Size at which messages outside of chunks become a chunk [bytes]."""
_CRC = 4
"""Size of a checksum [bytes]: the last field of the footer."""


@dataclass(frozen=True)
class RewriteSummary:
    """What was kept and lost in a rewritten file."""

    foreign: bool
    """Whether another program wrote the file; its rows are messages."""
    whole: bool
    """Whether nothing is lost, and the end is there."""
    messages: int
    rows: int
    """Samples."""
    duration: float
    """Time from the first message to the last [s]."""
    lost_rows: int | None
    """By the index of the old file, or gaps of the SYNC counter; None where neither tells."""
    lost_chunks: int
    """Chunks that are damaged, or whose head is lost."""
    lost_bytes: int
    """Bytes of damaged records, and of what is no record."""
    lost_records: tuple[str, ...]
    """Those of `rig` and `run` that the old file does not hold any more."""
    altered: bool
    """Whether the checksum of the old file says that something else was changed, which may be in `rig` or `run`."""

    @property
    def kind(self) -> str:
        """What the rows are."""
        return "messages" if self.foreign else "samples"

    @property
    def loss(self) -> str:
        """What was lost, in words."""
        rows = "an unknown number of" if self.lost_rows is None else self.lost_rows
        return f"{rows} {self.kind}, {self.lost_chunks} chunks, {self.lost_bytes} bytes"


def rewrite(
    source: Path,
    out: Path,
    run: Mapping[str, str],
    samples: SampleTable | None = None,
    rig: Rig | None = None,
) -> RewriteSummary:
    """Copy everything intact in `source` to the new file `out`, followed by `samples` and a final record `run`.

    rig: in place of a record `rig` that is lost.

    Raises:
        BadInput: `source` is missing, not MCAP, or contains nothing intact; `out` exists or cannot be created.
        OSError: `out` cannot be written; the partial file is removed.
    """
    with container.open_records(source) as stream:
        intact = IntactRecords(stream)
        with new_file(out) as target:
            rewriter = _Rewriter(source, intact, target)
            rewriter.copy_intact()
            rewriter.finish(run, samples, rig)
        return rewriter.summary(np.empty(0, np.int64) if rewriter.foreign else _cycles(out))


def _cycles(path: Path) -> Ints:
    """(n,) SYNC counters of the samples in a whole recording."""
    batches = container.load(path, (_SAMPLES,)).batches.get(_SAMPLES, [])
    return np.concatenate([np.empty(0, np.int64), *(batch["message"]["cycle"].astype(np.int64) for batch in batches)])


class _Rewriter:
    def __init__(self, source: Path, intact: IntactRecords, target: BinaryIO) -> None:
        self._source, self._intact = source, intact
        header = next((header for _, header in intact.decoded(Opcode.HEADER)), Header("", LIBRARY))
        own = {record.name for _, record in intact.decoded(Opcode.METADATA)} & {"rig", "run"}
        self.foreign = header.library != LIBRARY and not own
        self._writer = ContainerWriter(target, header if self.foreign else None)
        self._loose = bytearray()
        self._topics: dict[int, str] = {}
        self._metadata: dict[str, dict[str, str]] = {}
        self._messages = self._chunks = 0
        self._first, self._last = 2**63, 0
        self._damaged: list[Span] = []

    def copy_intact(self) -> None:
        """Copy what is not damaged."""
        for span in self._intact.spans:
            try:
                self._copy(span)
            except container.DECODE_ERRORS:
                self._damaged.append(span)
        if self.foreign:
            self._loose += self._intact.beginning
            self._pack_loose()
        if not self._messages:
            raise BadInput(
                f"recording {self._source} holds no intact data, so there is nothing to recover; record again"
            )

    def finish(self, run: Mapping[str, str], samples: SampleTable | None, rig: Rig | None) -> None:
        """Write `samples`, `run`, what stands for records that are lost, and the end."""
        channels = {topic: channel for channel, topic in self._topics.items()}
        for each in () if samples is None else encode(samples, channels):
            self._writer.chunk(each)
        for _, known in message_types():
            if known.topic in schemas.TOPICS:  # every recording has them, with messages or without
                self._describe_if_lost(known.id)
        for name, values in self._metadata.items():
            if name not in self._lost_records:
                self._writer.metadata(name, values)
        if "rig" in self._lost_records and rig is not None:
            self._writer.metadata("rig", rig_record(rig))
        if "run" in self._lost_records:
            self._writer.metadata("run", run_record(_unknown_run(self._first)))
        if not self.foreign:
            self._writer.metadata("run", run)
        self._writer.finish()

    def summary(self, cycles: Ints) -> RewriteSummary:
        """What was kept and lost; cycles: (n,) SYNC counters of the samples that were kept."""
        lost = self._intact.skipped + sum(span.end - span.start for span in self._damaged)
        lost -= self._intact.cut if self.foreign else 0
        whole = not lost and any(span.opcode == Opcode.FOOTER for span in self._intact.spans)
        rows = self._messages if self.foreign else len(cycles)
        damaged = sum(span.opcode == Opcode.CHUNK for span in self._damaged)
        announced = sum(span.opcode == Opcode.CHUNK_INDEX for span in self._intact.spans)
        return RewriteSummary(
            foreign=self.foreign,
            whole=whole,
            messages=self._messages,
            rows=rows,
            duration=(self._last - self._first) / 1e9,
            lost_rows=0 if whole else self._lost_rows(rows, cycles),
            lost_chunks=max(damaged, announced - self._chunks),
            lost_bytes=lost,
            lost_records=self._lost_records,
            altered=not lost and self._is_altered(),
        )

    @property
    def _lost_records(self) -> tuple[str, ...]:
        valid = {} if self.foreign else {"rig": _is_rig, "run": _is_run}
        return tuple(name for name, is_valid in valid.items() if not is_valid(self._metadata.get(name, {})))

    def _is_altered(self) -> bool:
        """Whether the data, or the summary behind it with the head of its footer, is not as its checksum says."""
        data = [(end.data_section_crc, 0, span.start) for span, end in self._intact.decoded(Opcode.DATA_END)]
        summary = [
            (footer.summary_crc, footer.summary_start, span.end - _CRC)
            for span, footer in self._intact.decoded(Opcode.FOOTER)
        ]
        # 0: written without a checksum
        return any(stated not in (0, self._intact.checksum(start, end)) for stated, start, end in data + summary)

    def _lost_rows(self, kept: int, cycles: Ints) -> int | None:
        """Number of rows, beside those `kept`, by the indexes of chunks, or that the SYNC counter leaves out."""
        channels = {channel for channel, topic in self._topics.items() if self.foreign or topic == _SAMPLES}
        for _, statistics in self._intact.decoded(Opcode.STATISTICS):
            counts = statistics.channel_message_counts
            written = sum(int(counts.get(channel, 0)) for channel in channels)
            return max(written - kept, 0)
        if not any(span.opcode == Opcode.DATA_END for span in self._intact.spans):
            return None  # nothing tells what came behind the last sample
        indexes = self._intact.decoded(Opcode.MESSAGE_INDEX)
        announced = sum(len(index.records) for _, index in indexes if index.channel_id in channels)
        gaps = int(np.ptp(cycles)) + 1 - len(np.unique(cycles)) if len(cycles) else 0
        return max(announced - kept, gaps) or None

    def _copy(self, span: Span) -> None:
        if span.opcode == Opcode.CHUNK:
            chunk = container.decode(Chunk.read, self._intact.body(span))
            self._writer.chunk(Packed(chunk, self._indexed(unpacked(chunk))))
            self._chunks += 1
        elif span.opcode == Opcode.METADATA:
            record = container.decode(Metadata.read, self._intact.body(span))
            self._metadata.setdefault(record.name, {}).update(record.metadata)
        elif span.opcode == Opcode.MESSAGE:
            body = self._intact.body(span)
            self._loose += RECORD.pack(span.opcode, len(body)) + body if self.foreign else b""
            if len(self._loose) > _LOOSE:
                self._pack_loose()
        else:
            self._describe(span.opcode, self._intact.body(span))

    def _pack_loose(self) -> None:
        """Write the records that stand in no chunk as one."""
        data = bytes(self._loose)
        if index := self._indexed(data):
            self._writer.chunk(packed(data, index))
        self._loose.clear()

    def _indexed(self, data: bytes) -> Index:
        """Index of the messages in an unpacked chunk; what they need is described."""
        messages, other_records = located(data)
        for opcode, body in other_records:
            self._describe(opcode, body)
        index: dict[int, list[np.ndarray]] = {}
        for (channel, length), offsets in messages.items():
            self._describe_if_lost(channel)
            heads = rows(data, length, offsets)[:, : MESSAGE_HEAD.itemsize]
            log = heads.copy().view(MESSAGE_HEAD)["log"]
            index.setdefault(channel, []).append(np.column_stack([log, np.array(offsets, np.uint64)]))
            self._messages += len(offsets)
            self._first = min(self._first, int(log.min()))
            self._last = max(self._last, int(log.max()))
        return {channel: np.concatenate(entries) for channel, entries in index.items()}

    def _describe(self, opcode: int, body: bytes) -> None:
        if opcode == Opcode.SCHEMA:
            self._writer.describe(container.decode(Schema.read, body))
        elif opcode == Opcode.CHANNEL:
            channel = container.decode(Channel.read, body)
            self._topics[channel.id] = channel.topic
            self._writer.describe(channel)

    def _describe_if_lost(self, channel: int) -> None:
        """Describe a `channel` as this program does, if its description is lost."""
        if channel not in self._topics and not self.foreign:
            for schema, known in message_types():
                if known.id == channel:
                    self._topics[channel] = known.topic
                    self._writer.describe(schema, known)


def _is_rig(record: Mapping[str, str]) -> bool:
    try:
        Rig.model_validate_json(record.get("json", ""))
    except ValidationError:
        return False
    return record.get("layout") == schemas.LAYOUT


def _is_run(record: Mapping[str, str]) -> bool:
    try:
        Run.model_validate_strings(record)
    except ValidationError:
        return False
    return True


def _unknown_run(first: int) -> Run:
    """What stands for a record `run` that is lost; first: time of the first message [ns]."""
    return Run(
        trajectory=LOST,
        trajectory_digest="",
        period=0.0,
        cycles=0,
        rate=0.0,
        software=software(),
        simulated=False,
        pace="realtime",
        start=datetime.fromtimestamp(first / 1e9, UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    )
