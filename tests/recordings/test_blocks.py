"""Block writer: agreement with the SYNC-by-SYNC writer and with other MCAP tools."""

import dataclasses
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from typing import BinaryIO

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.data_stream import ReadDataStream
from mcap.reader import make_reader
from mcap.records import Chunk, ChunkIndex, Message, MessageIndex
from rosbags.highlevel import AnyReader

from recordings import blocks
from recordings.blocks import SampleTable
from recordings.chunk import RECORD_HEAD, unpacked
from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.recording import Run
from recordings.rig import Axis, Rig


def axes(dof: int) -> Rig:
    return Rig(name="bench", mechanism="axes", axes=(Axis(),) * dof)


def samples(n: int, dof: int = 3, start: int = 0, **columns: object) -> SampleTable:
    rng = np.random.default_rng(n)
    position = rng.normal(size=(n, dof))
    position[n // 2, 0] = np.nan
    stamp = start + np.cumsum(rng.integers(1, 10**7, size=n))
    return SampleTable(
        joints=axes(dof).joint_names,
        stamp=stamp,
        log=stamp + 700,
        cycle=np.arange(n),
        repeat=rng.integers(-1, 3, size=n),
        position=position,
        **columns,
    )


def test_block_writer_and_sync_writer_give_the_same_messages(
    tmp_path: Path, written: SimpleNamespace, rig: Rig, run: Run
) -> None:
    whole = SampleTable(
        joints=rig.joint_names,
        stamp=written.stamp,
        log=written.stamp + 700_000,
        cycle=np.arange(written.n),
        repeat=written.repeat,
        position=written.position,
        command=written.command,
        voltage=written.voltage,
        effort=written.effort,
        statusword=written.statusword,
        error_code=written.error_code,
    )
    blocks.write(tmp_path / "r.mcap", rig, run, whole)
    expected, actual = read(written.path), read(tmp_path / "r.mcap")
    for name in ("time", "position", "command", "voltage", "effort", "statusword", "error_code", "repeat"):
        np.testing.assert_array_equal(getattr(actual, name), getattr(expected, name), err_msg=name)
    assert actual.velocity is None
    with AnyReader([written.path]) as first, AnyReader([tmp_path / "r.mcap"]) as second:
        for topic in ("/joint_states", "/joint_commands", "/amplifiers"):
            theirs, ours = (
                [(log, data) for connection, log, data in reader.messages() if connection.topic == topic]
                for reader in (first, second)
            )
            if topic == "/amplifiers":  # lateness is not known here
                assert [log for log, _ in ours] == [log for log, _ in theirs]
            else:
                assert ours == theirs, f"{topic}: byte for byte"


@given(
    n=st.sampled_from([2, 5, blocks.ROWS, blocks.ROWS + 1]),
    dof=st.integers(1, 4),
    present=st.sets(st.sampled_from(["command", "voltage", "velocity", "effort"])),
    names=st.lists(st.text(min_size=1, max_size=5).filter(lambda text: "\0" not in text), unique=True, max_size=3),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=30)
def test_written_samples_are_read_back(
    tmp_path: Path, run: Run, n: int, dof: int, present: set[str], names: list[str]
) -> None:
    path = tmp_path / "r.mcap"
    path.unlink(missing_ok=True)
    rng = np.random.default_rng(0)
    given_arrays = {name: rng.normal(size=(n, dof)) for name in sorted(present)}
    extra = {name: rng.normal(size=n) for name in names}
    whole = samples(n, dof, 1_700_000_000_000_000_000, extra=extra, **given_arrays)
    blocks.write(path, axes(dof), run, whole)
    recording = read(path)
    np.testing.assert_array_equal(recording.time, (whole.stamp - whole.stamp[0]) / 1e9)
    np.testing.assert_array_equal(recording.position, whole.position)
    np.testing.assert_array_equal(recording.repeat, whole.repeat)
    gap = np.full((n, dof), np.nan)
    for name in ("command", "voltage"):
        np.testing.assert_array_equal(getattr(recording, name), given_arrays.get(name, gap))
    for name in ("velocity", "effort"):
        read_back = getattr(recording, name)
        assert (read_back is None) == (name not in given_arrays)
        if read_back is not None:
            np.testing.assert_array_equal(read_back, given_arrays[name])
    assert list(recording.extra) == names
    for name in names:
        np.testing.assert_array_equal(recording.extra[name], extra[name])
    assert len(read_can(path).id) == 0


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
    whole = samples(n, extra={"temperature": np.arange(n) / 2})
    blocks.write(path, rig, run, whole)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        statistics = reader.get_summary().statistics
        logs = [message.log_time for _, _, message in reader.iter_messages("/joint_states")]
        for chunk_index in reader.get_summary().chunk_indexes:
            assert_index_is_true(stream, chunk_index)
        names = [record.name for record in reader.iter_metadata()]
    assert logs == whole.log.tolist()
    assert (statistics.message_count, statistics.chunk_count, statistics.metadata_count) == (3 * n, 3, 2)
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


def test_existing_file_is_kept_and_failed_write_leaves_no_file(tmp_path: Path, rig: Rig, run: Run) -> None:
    (tmp_path / "there.mcap").write_text("precious")
    with pytest.raises(BadInput, match="exists; choose another name"):
        blocks.write(tmp_path / "there.mcap", rig, run, samples(5))
    assert (tmp_path / "there.mcap").read_text() == "precious"
    with pytest.raises(ValueError, match="reshape"):
        blocks.write(tmp_path / "r.mcap", rig, run, dataclasses.replace(samples(5), command=np.zeros((5, 2))))
    assert not (tmp_path / "r.mcap").exists()
