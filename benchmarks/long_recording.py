"""Create recordings of any length by repeating one cycle of a recording, with all its frames and topics."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Schema

from recordings import schemas
from recordings.cdr import Layout
from recordings.chunk import MESSAGE_HEAD, located, message_record, rows, unpacked
from recordings.container import Batch, decode, open_records
from recordings.container_writer import ContainerWriter, pack
from recordings.files import new_file
from recordings.reader import read

CHUNK = 500_000_000
"""Recorded time in one chunk [ns], as in the recorder's files."""


def make(source: Path, path: Path, seconds: float) -> None:
    """Write at least `seconds` of the cyclic motion of the recording `source` to `path`."""
    recording = read(source)
    messages = _messages(source)
    cycled = [part for part in messages if "repeat" in (part["message"].dtype.names or ())]
    start = min(int(part["log"][part["message"]["repeat"] == 0].min(initial=2**62)) for part in cycled)
    period = round(1e9 * recording.run.period)
    repetitions = int(np.ceil(1e9 * seconds / period))
    cycle = [part[(part["log"] >= start) & (part["log"] < start + period)] for part in messages]
    with new_file(path) as stream:
        writer = ContainerWriter(stream)
        for name, record in _descriptors(source, repetitions):
            writer.metadata(name, record)
        for schema, channel in _descriptions(source):
            writer.describe(schema, channel)
        for repetition in range(repetitions):
            for first in range(start, start + period, CHUNK):
                chosen = [part[(part["log"] >= first) & (part["log"] < first + CHUNK)] for part in cycle]
                _write_chunk(writer, [part for part in chosen if len(part)], repetition, period)
        writer.finish()


def _descriptors(source: Path, repetitions: int) -> Iterator[tuple[str, dict[str, str]]]:
    """Records of rig and run as they stand in `source`, so that the checkout that wrote them can read the copy."""
    with source.open("rb") as stream:
        rig, run, *_ = make_reader(stream).iter_metadata()
    yield "rig", rig.metadata
    yield "run", run.metadata | {"cycles": str(repetitions)}


def _write_chunk(writer: ContainerWriter, parts: list[Batch], repetition: int, period: int) -> None:
    copies = []
    for part in parts:
        moved = part.copy()
        moved["log"] += repetition * period
        moved["publish"] += repetition * period
        stamp = moved["message"]["header.stamp"]
        nanoseconds = stamp["sec"].astype(np.int64) * 10**9 + stamp["nanosec"] + repetition * period
        stamp["sec"], stamp["nanosec"] = np.divmod(nanoseconds, 10**9)
        if "repeat" in (moved["message"].dtype.names or ()):
            moved["message"]["repeat"] = repetition
        copies.append(moved)
    writer.chunk(pack(copies))


def _messages(source: Path) -> list[Batch]:
    """All messages of stamped topics, one array for each chunk, topic and length."""
    topics = {channel.id: channel.topic for _, channel in _descriptions(source)}
    messages = []
    with open_records(source) as stream:
        chunks = [decode(Chunk.read, body) for opcode, _, body in stream.records() if opcode == Opcode.CHUNK]
    for data in map(unpacked, chunks):
        for (channel, length), offsets in located(data)[0].items():
            if topics[channel] not in ("/events", *schemas.DESCRIPTION_TOPICS):
                raw = rows(data, length, offsets)
                layout = Layout.of(schemas.FIELDS[topics[channel]], raw[0, MESSAGE_HEAD.itemsize :].tobytes())
                messages.append(raw.view(message_record(layout))[:, 0])
    return messages


def _descriptions(source: Path) -> list[tuple[Schema, Channel]]:
    with source.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None, "recordings of a whole run have one"
    return [(summary.schemas[channel.schema_id], channel) for channel in summary.channels.values()]
