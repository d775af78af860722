"""Writing samples that are complete arrays, in blocks; `RecordingWriter` writes one SYNC at a time."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from numpy.typing import NDArray

from recordings import schemas
from recordings.cdr import HEADER, Layout
from recordings.chunk import MESSAGE_HEAD, RECORD_HEAD, message_record
from recordings.container import Batch
from recordings.container_writer import ContainerWriter, Packed, pack
from recordings.description import description_messages
from recordings.files import new_file
from recordings.metadata import rig_record, run_record
from recordings.recording import Floats, Ints, Run
from recordings.rig import Rig

ROWS = 4096
"""Samples in one chunk."""
Values = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class SampleTable:
    """n samples of dof joints, as in `Recording`; None for quantities that were not measured."""

    joints: tuple[str, ...]
    """(dof,) names."""
    stamp: Ints
    """(n,) SYNC instants [ns], ascending."""
    log: Ints
    """(n,) arrival time at the host [ns]."""
    cycle: Ints
    """(n,) SYNC counter."""
    repeat: Ints
    position: Floats
    command: Floats | None = None
    voltage: Floats | None = None
    velocity: Floats | None = None
    effort: Floats | None = None
    statusword: Ints | None = None
    error_code: Ints | None = None
    extra: Mapping[str, Floats] = field(default_factory=dict)
    """Name: (n,)."""


def write(path: Path, rig: Rig, run: Run, samples: SampleTable) -> None:
    """Write a complete recording of `samples` that did not come over a bus: no frames, no events.

    Raises:
        BadInput: the file exists, or cannot be created.
        OSError: the file cannot be written; the partial file is removed.
    """
    description = description_messages(rig)
    with new_file(path) as stream:
        writer = ContainerWriter(stream)
        channels = {}
        for schema, channel in message_types():
            if channel.topic not in schemas.OPTIONAL_TOPICS or samples.extra:
                writer.describe(schema, channel)
                channels[channel.topic] = channel.id
        writer.metadata("rig", rig_record(rig))
        writer.metadata("run", run_record(run.model_copy(update={"exit_status": None})))
        if description:
            writer.chunk(pack(_single(samples, channels[topic], payload) for topic, payload in description.items()))
        for chunk in encode(samples, channels):
            writer.chunk(chunk)
        if run.exit_status is not None:  # at the end, so that a truncated file has no exit status
            writer.metadata("run", {"exit_status": str(run.exit_status)})
        writer.finish()


def message_types() -> Iterator[tuple[Schema, Channel]]:
    """Yield the schema and the channel of each topic as this program numbers them, the optional ones last."""
    for number, (topic, (name, text)) in enumerate(schemas.ALL_TOPICS.items(), start=1):
        schema = Schema(id=number, name=name, encoding="ros2msg", data=text.encode())
        yield schema, Channel(id=number, topic=topic, message_encoding="cdr", metadata={}, schema_id=number)


def encode(samples: SampleTable, channels: Mapping[str, int]) -> Iterator[Packed]:
    """Yield chunks of `ROWS` samples each; `channels` maps each topic to its channel."""
    for first in range(0, len(samples.stamp), ROWS):
        block = slice(first, first + ROWS)
        contents = _contents(samples, block)
        yield pack(_messages(samples, block, topic, channels[topic], *content) for topic, content in contents.items())


def _messages(
    samples: SampleTable, block: slice, topic: str, channel: int, strings: Sequence[str], values: Values
) -> Batch:
    """Message records of one topic, one for each sample of `block`, with these names and values by field."""
    dof = samples.position.shape[1]
    sequences = {name: len(strings) if name in ("name", "value") else dof for name in ("name", "value", *values)}
    # Sequences of quantities that were not measured are empty, as usual in ROS.
    lengths = {name: sequences.get(name, 0) for name in ("velocity", "effort")} | sequences
    texts = {"header.frame_id": "", **{f"name.{i}": name for i, name in enumerate(strings)}}
    known = {name: len(text.encode()) + 1 for name, text in texts.items()} | lengths
    layout = Layout(schemas.FIELDS[topic], lambda name, _: known[name])
    records = _records(samples, block, channel, message_record(layout))
    message = records["message"]
    message["encapsulation"] = int.from_bytes(HEADER, "little")
    for length in layout.lengths:
        message[f"length of {length.name}"] = length.value
    for name, text in texts.items():
        message[name] = text.encode()
    _fill_time(message["header.stamp"], samples.stamp[block])
    for name, value in values.items():
        # A sequence of length one has no axis in the dtype.
        message[name] = value.reshape(message[name].shape)
    return records


def _single(samples: SampleTable, channel: int, payload: bytes) -> Batch:
    """The record of the only message of a topic, at the first sample."""
    record = _records(samples, slice(1), channel, np.dtype([*MESSAGE_HEAD.descr, ("message", f"V{len(payload)}")]))
    record["message"] = np.void(payload)
    return record


def _records(samples: SampleTable, block: slice, channel: int, dtype: np.dtype[Any]) -> Batch:
    """Message records of a channel, one for each sample of `block`, of which `message` is still empty."""
    records = np.zeros(len(samples.stamp[block]), dtype)
    records["opcode"] = Opcode.MESSAGE
    records["length"] = records.itemsize - RECORD_HEAD
    records["channel"] = channel
    records["log"] = samples.log[block]
    records["publish"] = samples.stamp[block]
    return records


def _contents(samples: SampleTable, block: slice) -> dict[str, tuple[Sequence[str], Values]]:
    """Names in the messages, and the values by field, of each topic."""
    n, dof = samples.position[block].shape
    measured = {"position": samples.position, "velocity": samples.velocity, "effort": samples.effort}
    states = {name: value[block] for name, value in measured.items() if value is not None}
    gap, zeros = np.full((n, dof), np.nan), np.zeros((n, dof), np.int64)
    stamps = np.zeros((n, dof), [("sec", "<i4"), ("nanosec", "<u4")])
    _fill_time(stamps, samples.stamp[block, None])
    amplifiers = {
        "cycle": samples.cycle[block],
        "repeat": samples.repeat[block],
        "lateness": gap[:, 0],
        "voltage": gap if samples.voltage is None else samples.voltage[block],
        "voltage_stamp": stamps,
        "statusword": zeros if samples.statusword is None else samples.statusword[block],
        "error_code": zeros if samples.error_code is None else samples.error_code[block],
    }
    contents: dict[str, tuple[Sequence[str], Values]] = {"/joint_states": (samples.joints, states)}
    if samples.command is not None:
        contents["/joint_commands"] = samples.joints, {"position": samples.command[block]}
    contents["/amplifiers"] = (), amplifiers
    if samples.extra:
        further = np.column_stack([value[block] for value in samples.extra.values()])
        contents["/extra"] = tuple(samples.extra), {"value": further}
    return contents


def _fill_time(time: NDArray[Any], stamp: Ints) -> None:
    time["sec"], time["nanosec"] = np.divmod(stamp, 10**9)
