"""Create recordings of any length by repeating one cycle of a recording, with all its frames and topics."""

from pathlib import Path
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Schema
from numpy.typing import NDArray

from recordings import schemas
from recordings.cdr import Layout, parse_schema
from recordings.container import contents, decode, located, records, rows, unpacked
from recordings.container_writer import ContainerWriter, create, pack
from recordings.metadata import rig_record, run_record
from recordings.reader import read

CHUNK = 500_000_000
"""Recorded time in one chunk [ns], as in the recorder's files."""
HEAD = [("before", "V15"), ("log", "<u8"), ("publish", "<u8")]
"""Fields before the message in a Message record: opcode, length, channel and sequence, then two times [ns]."""
HEAD_SIZE = 31

Messages = NDArray[Any]
"""Message records of the same channel and length, with the fields of `HEAD` and `message`."""


def make(source: Path, path: Path, seconds: float) -> None:
    """Write at least `seconds` of the cyclic motion of the recording `source` to `path`."""
    recording = read(source)
    messages = _messages(source)
    cycled = [part for part in messages if "repeat" in (part["message"].dtype.names or ())]
    start = min(int(part["log"][part["message"]["repeat"] == 0].min(initial=2**62)) for part in cycled)
    period = round(1e9 * recording.run.period)
    repetitions = int(np.ceil(1e9 * seconds / period))
    cycle = [part[(part["log"] >= start) & (part["log"] < start + period)] for part in messages]
    with create(path) as stream:
        writer = ContainerWriter(stream)
        writer.metadata("rig", rig_record(recording.rig))
        writer.metadata("run", run_record(recording.run.model_copy(update={"cycles": repetitions})))
        for schema, channel in _descriptions(source):
            writer.describe([schema], [channel])
        for repetition in range(repetitions):
            for first in range(start, start + period, CHUNK):
                chosen = [part[(part["log"] >= first) & (part["log"] < first + CHUNK)] for part in cycle]
                _write_chunk(writer, [part for part in chosen if len(part)], repetition, period)
        writer.finish()


def _write_chunk(writer: ContainerWriter, parts: list[Messages], repetition: int, period: int) -> None:
    index: dict[int, list[NDArray[np.uint64]]] = {}
    data, offset = [], 0
    for part in parts:
        moved = part.copy()
        moved["log"] += repetition * period
        moved["publish"] += repetition * period
        stamp = moved["message"]["header.stamp"]
        nanoseconds = stamp["sec"].astype(np.int64) * 10**9 + stamp["nanosec"] + repetition * period
        stamp["sec"], stamp["nanosec"] = np.divmod(nanoseconds, 10**9)
        if "repeat" in (moved["message"].dtype.names or ()):
            moved["message"]["repeat"] = repetition
        places = offset + moved.dtype.itemsize * np.arange(len(moved), dtype=np.uint64)
        channel = int.from_bytes(moved["before"][0].tobytes()[9:11], "little")
        index.setdefault(channel, []).append(np.column_stack([moved["log"], places]))
        data.append(moved.tobytes())
        offset += moved.nbytes
    writer.chunk(pack(b"".join(data), {channel: np.concatenate(parts) for channel, parts in index.items()}))


def _messages(source: Path) -> list[Messages]:
    """All messages of stamped topics, one array for each chunk, topic and length."""
    topics = {channel.id: channel.topic for _, channel in _descriptions(source)}
    messages = []
    for opcode, _, body in records(contents(source)):
        if opcode != Opcode.CHUNK:
            continue
        data = unpacked(decode(Chunk.read, body))
        for (channel, length), offsets in located(data)[0].items():
            if topics[channel] != "/events":
                raw = rows(data, length, offsets)
                fields = parse_schema(schemas.TOPICS[topics[channel]][1])
                layout = Layout.of(fields, raw[0, HEAD_SIZE:].tobytes())
                messages.append(raw.view(np.dtype([*HEAD, ("message", layout.dtype)]))[:, 0])
    return messages


def _descriptions(source: Path) -> list[tuple[Schema, Channel]]:
    with source.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None, "recordings of a whole run have one"
    return [(summary.schemas[channel.schema_id], channel) for channel in summary.channels.values()]
