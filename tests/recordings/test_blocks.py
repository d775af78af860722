"""Block writer: agreement with the SYNC-by-SYNC writer and with other MCAP tools."""

from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import BinaryIO

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex, Message, MessageIndex
from rosbags.highlevel import AnyReader

from recordings import blocks, schemas
from recordings.blocks import SampleTable
from recordings.chunk import RECORD_HEAD, unpacked
from recordings.reader import read
from recordings.recording import Run
from recordings.rig import Rig
from tests.arrays import assert_same


def test_block_writer_and_sync_writer_give_the_same_messages(
    tmp_path: Path, written: SimpleNamespace, rig: Rig, run: Run
) -> None:
    names = ("stamp", "repeat", "position", "command", "voltage", "effort", "statusword", "error_code")
    columns = {name: getattr(written, name) for name in names}
    whole = SampleTable(joints=rig.joint_names, log=written.stamp + 700_000, cycle=np.arange(written.n), **columns)
    blocks.write(tmp_path / "r.mcap", rig, run, whole)
    expected, actual = read(written.path), read(tmp_path / "r.mcap")
    arrays = ("time", "position", "command", "voltage", "effort", "statusword", "error_code", "repeat")
    assert_same(actual, expected, *arrays)
    assert actual.velocity is None
    with AnyReader([written.path]) as first, AnyReader([tmp_path / "r.mcap"]) as second:
        for topic in ("/joint_states", "/joint_commands", "/amplifiers", *schemas.DESCRIPTION_TOPICS):
            theirs, ours = (
                [(log, data) for connection, log, data in reader.messages() if connection.topic == topic]
                for reader in (first, second)
            )
            if topic == "/amplifiers":  # lateness is not known here
                assert [log for log, _ in ours] == [log for log, _ in theirs]
            elif topic in schemas.DESCRIPTION_TOPICS:  # frames come before the first sample
                assert [data for _, data in ours] == [data for _, data in theirs]
                assert len(ours) == 1
            else:
                assert ours == theirs, f"{topic}: byte for byte"


def assert_index_is_true(stream: BinaryIO, chunk_index: ChunkIndex) -> None:
    """Every entry of a chunk's message indexes points at a message of that channel and time."""
    stream.seek(chunk_index.chunk_start_offset + RECORD_HEAD)
    data = unpacked(Chunk.read(ReadDataStream(stream)))
    for channel, place in chunk_index.message_index_offsets.items():
        stream.seek(place + RECORD_HEAD)
        entries = MessageIndex.read(ReadDataStream(stream)).records
        assert entries
        for log, offset in entries:
            message = Message.read(ReadDataStream(BytesIO(data[offset + RECORD_HEAD :])), 22)
            assert (message.channel_id, message.log_time) == (channel, log)


def test_message_index_points_at_every_message(tmp_path: Path, rig: Rig, run: Run) -> None:
    path = tmp_path / "r.mcap"
    n = 2 * blocks.ROWS + 10
    rng = np.random.default_rng(n)
    stamp = np.cumsum(rng.integers(1, 10**7, size=n))
    whole = SampleTable(
        joints=rig.joint_names,
        stamp=stamp,
        log=stamp + 700,
        cycle=np.arange(n),
        repeat=rng.integers(-1, 3, size=n),
        position=rng.normal(size=(n, 3)),
        extra={"temperature": np.arange(n) / 2},
    )
    blocks.write(path, rig, run, whole)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        statistics = reader.get_summary().statistics
        logs = [message.log_time for _, _, message in reader.iter_messages("/joint_states")]
        for chunk_index in reader.get_summary().chunk_indexes:
            assert_index_is_true(stream, chunk_index)
        names = [record.name for record in reader.iter_metadata()]
    assert logs == whole.log.tolist()
    np.testing.assert_array_equal(read(path).position, whole.position)
    assert (statistics.message_count, statistics.chunk_count, statistics.metadata_count) == (3 * n + 2, 4, 2)
    assert (statistics.message_start_time, statistics.message_end_time) == (whole.log[0], whole.log[-1])
    assert names == ["rig", "run"]
    with AnyReader([path]) as reader:
        messages = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == "/extra"
        ]
    assert messages[7].name == ["temperature"]
    assert messages[7].value.tolist() == [3.5]
