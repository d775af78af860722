"""Writer: files read by other tools, flushing, and failures."""

import errno
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from recordings import schemas
from recordings.description import urdf_of
from recordings.errors import BadInput, RunFailed
from recordings.reader import read, read_can
from recordings.recording import Run
from recordings.rig import Rig
from recordings.writer import RecordingWriter
from tests.arrays import assert_same


def test_rosbags_reads_every_topic(written: SimpleNamespace, rig: Rig) -> None:
    with AnyReader([written.path]) as reader:
        messages = {topic: [] for topic in (*schemas.TOPICS, *schemas.DESCRIPTION_TOPICS)}
        for connection, log, payload in reader.messages():
            messages[connection.topic].append((log, reader.deserialize(payload, connection.msgtype)))
    assert {topic: len(topics) for topic, topics in messages.items()} == {
        "/joint_states": written.n,
        "/joint_commands": written.n,
        "/amplifiers": written.n,
        "/platform_reference": written.n,
        "/can": 2 * written.n,
        "/events": 3,
        "/robot_description": 1,
        "/tf_static": 1,
    }
    assert messages["/robot_description"][0][1].data == urdf_of(rig)
    row = SimpleNamespace(**{name: values[6] for name, values in vars(written).items() if np.ndim(values)})
    _, state = messages["/joint_states"][6]
    assert state.header.stamp.sec * 10**9 + state.header.stamp.nanosec == row.stamp
    assert state.name == ["joint_1", "joint_2", "joint_3"]
    assert_same(state, row, "position", "effort")
    assert len(state.velocity) == 0
    _, amplifiers = messages["/amplifiers"][6]
    assert_same(amplifiers, row, "repeat", "lateness", "voltage", "statusword", "error_code")
    assert amplifiers.cycle == 6
    assert [stamp.nanosec for stamp in amplifiers.voltage_stamp] == [amplifiers.header.stamp.nanosec] * 3
    log, frame = messages["/can"][1]
    assert (frame.header.frame_id, frame.id, frame.dlc) == ("rx", 0x181, 3)
    assert (bytes(frame.data), log - written.stamp[0]) == (b"\x00\x02\x03\0\0\0\0\0", 700_000)
    _, event = messages["/events"][1]
    assert (event.level, event.name, event.msg) == (30, "cycle", "Überlänge: missed 1")


def test_mcap_reader_opens_the_file_by_its_index_and_finds_its_metadata(written: SimpleNamespace, rig: Rig) -> None:
    with written.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        records = [(record.name, record.metadata) for record in reader.iter_metadata()]
        summary = reader.get_summary()
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count == 6 * written.n + 5
        assert reader.get_header().profile == "ros2"
    (_, rig_record), (_, run_record), last = records
    assert Rig.model_validate_json(rig_record["json"]) == rig
    assert (run_record["trajectory"], run_record["rate"], run_record["simulated"]) == ("fig5a", "500.0", "true")
    assert last == ("run", {"exit_status": "0", "reason": "trajectory done"})
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}


def test_a_killed_program_loses_at_most_a_quarter_of_a_second(tmp_path: Path, rig: Rig, run: Run) -> None:
    writer = RecordingWriter(tmp_path / "r.mcap", rig, run)
    end = 2_498_000_000  # just before the next flush
    for stamp in range(0, end + 1, 2_000_000):
        writer.joint_states(stamp, stamp, (0.1, 0.2, 0.3))
        writer.joint_commands(stamp, stamp, (0.1, 0.2, 0.3))
        writer.amplifiers(stamp, stamp, 0, 0, 0.0, (1.0, 2.0, 3.0), (0, 0, 0), (0, 0, 0))
    copy = tmp_path / "as_left_behind.mcap"
    copy.write_bytes((tmp_path / "r.mcap").read_bytes())
    writer.close(0, "done")
    recording = read(copy)
    assert recording.time[-1] >= end / 1e9 - 0.25
    assert not recording.complete
    assert read(tmp_path / "r.mcap").time[-1] == pytest.approx(end / 1e9)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("missing/r.mcap", "does not exist; create it"),
        ("file/r.mcap", "Not a directory"),
        ("folder", "exists"),
        ("r.mcap", "exists; give another one"),
    ],
)
def test_paths_where_no_file_can_be_created_are_bad_input(
    tmp_path: Path, rig: Rig, run: Run, name: str, reason: str
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    (tmp_path / "r.mcap").write_text("precious")
    with pytest.raises(BadInput, match=reason):
        RecordingWriter(tmp_path / name, rig, run)
    assert (tmp_path / "r.mcap").read_text() == "precious"


def test_exception_in_the_context_is_recorded_as_the_reason(tmp_path: Path, rig: Rig, run: Run) -> None:
    path = tmp_path / "r.mcap"

    def fail() -> None:
        with RecordingWriter(path, rig, run) as writer:
            writer.joint_states(0, 0, (0.1, 0.2, 0.3))
            raise RunFailed("drive 2 \udcff: fault")

    with pytest.raises(RunFailed):
        fail()
    recording = read(path)
    assert (recording.run.exit_status, recording.run.reason) == (1, "drive 2 ?: fault")


def test_second_close_has_no_effect_and_writing_after_close_fails(tmp_path: Path, rig: Rig, run: Run) -> None:
    path = tmp_path / "r.mcap"
    with RecordingWriter(path, rig, run) as writer:
        writer.joint_states(0, 0, (0.1, 0.2, 0.3))
        writer.close(1, "first")
        writer.close(0, "second")
        with pytest.raises(RunFailed, match="closed"):
            writer.joint_states(1, 1, (0.1, 0.2, 0.3))
    assert read(path).run.reason == "first"


@contextmanager
def file_size_limit(size: int) -> Iterator[None]:
    """Let writing to a file fail beyond `size` bytes, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize(("size", "left_behind"), [(0, False), (10_000, True)])
def test_full_disk_at_the_start_or_the_end_is_reported(
    tmp_path: Path, rig: Rig, run: Run, size: int, left_behind: bool
) -> None:
    def record() -> None:
        with RecordingWriter(tmp_path / "r.mcap", rig, run) as writer:
            for stamp in range(0, 400_000_000, 1_000_000):
                writer.can(stamp, stamp, stamp % 2048, stamp.to_bytes(8, "little"), sent=True)

    with file_size_limit(size), pytest.raises(RunFailed, match="cannot be written") as failure:
        record()
    assert isinstance(failure.value.__cause__, OSError)
    assert failure.value.__cause__.errno == errno.EFBIG
    assert (tmp_path / "r.mcap").exists() == left_behind


def test_can_frames_keep_their_flags(tmp_path: Path, rig: Rig, run: Run) -> None:
    path = tmp_path / "r.mcap"
    with RecordingWriter(path, rig, run) as writer:
        writer.can(5, 9, 0x1FFFFFFF, b"\1", sent=False, extended=True)
        writer.can(6, 8, 0x701, b"", sent=True, rtr=True)
        writer.can(7, 7, 0x20, bytes(8), sent=False, error=True)
    frames = read_can(path)
    assert frames.stamp.tolist() == [7, 6, 5], "by log time"
    assert frames.log.tolist() == [7, 8, 9]
    assert frames.id.tolist() == [0x20, 0x701, 0x1FFFFFFF]
    assert frames.dlc.tolist() == [8, 0, 1]
    assert frames.data.tolist() == [[0] * 8, [0] * 8, [1, *[0] * 7]]
    assert frames.sent.tolist() == [False, True, False]
    assert frames.rtr.tolist() == [False, True, False]
    assert frames.extended.tolist() == [False, False, True]
    assert frames.error.tolist() == [True, False, False]
