"""A recording with what the model says of it: residual, noise floor and each cause as topics, for a viewer.

Samples, frames and events of the recording are copied as they are. Efforts are conditioned as by `ident compare`.
"""

from collections.abc import Callable, Iterator

import numpy as np
from mcap.reader import McapReader, make_reader
from mcap.writer import Writer

from ident.estimation import chunks
from ident.export.losses import Carried, sorted_by
from ident.export.paths import RecordedPath
from ident.export.targets import ExportRequest
from ident.export.targets import beside as carried_file
from ident.export.torque_table import evaluate
from recordings import schemas
from recordings.cdr import Encoder
from recordings.container_writer import LIBRARY, PROFILE
from recordings.description import description_messages
from recordings.errors import BadInput, told
from recordings.files import replacement
from recordings.recording import Floats
from recordings.sync_grid import SYNC_TOPICS
from trajectories.transforms import Transforms

__all__ = ["carried_file", "write"]

TF_RATE = 50.0
"""Poses of the links per second [Hz]: as many as a screen shows."""

Add = Callable[[str, tuple[str, str], int, bytes], None]
"""Adds a message: topic, name and text of its type, stamp [ns], payload."""


def write(request: ExportRequest) -> Carried:
    """See `Target`.

    Raises:
        BadInput: the path is no recording that lies in a file.
    """
    path = request.path
    if not isinstance(path, RecordedPath) or not path.prepared.recording.path.is_file():
        raise BadInput(
            f"export to mcap: the file of a recording expected, {path.name} found; give it as "
            + told("--on FILE", "on")
        )
    with (
        replacement(request.out) as partial,
        path.prepared.recording.path.open("rb") as source,
        partial.open("wb") as out,
    ):
        writer = Writer(out)
        writer.start(profile=PROFILE, library=LIBRARY)
        start = _copy(make_reader(source), writer)
        add = _adder(writer)
        for topic, message in description_messages(path.prepared.recording.rig).items():
            add(topic, schemas.DESCRIPTION_TOPICS[topic], start, message)
        for topic, efforts in _efforts(request, path):
            _add_efforts(add, topic, path, start, efforts)
        _add_poses(add, path, start)
        writer.finish()  # type: ignore[no-untyped-call]
    return sorted_by(request.model, {})


def _copy(reader: McapReader, writer: Writer) -> int:
    """Copy all but what is written anew; return the stamp of the first sample [ns]."""
    for metadata in reader.iter_metadata():
        writer.add_metadata(metadata.name, metadata.metadata)
    known: dict[int, int] = {}
    stamps = []
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        if channel.topic in schemas.DESCRIPTION_TOPICS or schema is None:
            continue
        if channel.id not in known:
            kind = writer.register_schema(schema.name, schema.encoding, schema.data)
            about = channel.topic, channel.message_encoding, kind, channel.metadata
            known[channel.id] = writer.register_channel(*about)
        if channel.topic in SYNC_TOPICS:
            stamps.append(message.publish_time)
        writer.add_message(known[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
    return min(stamps)


def _adder(writer: Writer) -> Add:
    known: dict[str, int] = {}

    def add(topic: str, kind: tuple[str, str], stamp: int, payload: bytes) -> None:
        if topic not in known:
            schema = writer.register_schema(kind[0], "ros2msg", kind[1].encode())
            known[topic] = writer.register_channel(topic, "cdr", schema)
        writer.add_message(known[topic], stamp, payload, stamp)

    return add


def _efforts(request: ExportRequest, path: RecordedPath) -> Iterator[tuple[str, Floats]]:
    """Topic and efforts (m, dof) [N m or N] of all that is written beside the samples."""
    prepared, model = path.prepared, request.model
    computed = chunks.torque(prepared, model.dynamics.structure, model.dynamics.values)
    yield "/torque/measured", prepared.torque
    yield "/torque/model", computed
    yield "/residual", prepared.torque - computed
    test = model.file.residual_test
    yield "/floor", np.broadcast_to(np.array(test.noise_rms if test else np.nan, float), computed.shape)
    evaluated = [evaluate(model, chunk)[1] for chunk in path.chunks()]
    for name in evaluated[0]:
        yield f"/causes/{name}", prepared.condition(np.concatenate([terms[name] for terms in evaluated]))


def _add_efforts(add: Add, topic: str, path: RecordedPath, start: int, efforts: Floats) -> None:
    """Add each row as a sensor_msgs/msg/JointState that holds efforts alone."""
    names = path.prepared.recording.rig.joint_names
    texts = {"header.frame_id": ""} | {f"name.{number}": name for number, name in enumerate(names)}
    lengths = {"name": len(names), "position": 0, "velocity": 0, "effort": len(names)}
    encoder = Encoder(schemas.FIELDS["/joint_states"], texts, lengths)
    times = path.prepared.instant_time[:: path.prepared.preprocessed.decimation]
    for stamp, row in zip(_stamps(start, times), efforts.tolist(), strict=True):
        add(topic, schemas.TOPICS["/joint_states"], stamp, encoder.pack([*divmod(stamp, 10**9), *row]))


def _add_poses(add: Add, path: RecordedPath, start: int) -> None:
    recording = path.prepared.recording
    due = np.unique(np.searchsorted(recording.time, np.arange(0.0, recording.time[-1], 1 / TF_RATE)))
    for stamp, message in Transforms(recording.rig).messages(
        _stamps(start, recording.time[due]), recording.position[due]
    ):
        add("/tf", schemas.TF_MESSAGE, stamp, message)


def _stamps(start: int, times: Floats) -> list[int]:
    """Stamps [ns] of `times` [s] from the first sample."""
    return (start + np.round(1e9 * times).astype(np.int64)).tolist()
