"""Reader: written data are read back from complete, truncated and damaged files."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from mcap_ros2.writer import Writer as Ros2Writer

from recordings import schemas
from recordings.errors import BadInput
from recordings.metadata import rig_record, run_record
from recordings.reader import is_foreign, read, read_can
from recordings.recording import Run
from recordings.rig import Rig
from recordings.writer import RecordingWriter
from tests.arrays import assert_same

SAMPLES = Path(__file__).parents[2] / "recordings" / "samples"
START = 1_700_000_000_000_000_000
EMPTY_RIG = Rig.model_validate_json('{"name": "r", "drives": [{"node_id": 1}, {"node_id": 2}, {"node_id": 3}]}')


def test_written_recording_is_read_back(written: SimpleNamespace, rig: Rig, run: Run) -> None:
    recording = read(written.path)
    arrays = ("position", "command", "voltage", "effort", "statusword", "error_code", "repeat", "lateness")
    assert_same(recording, written, *arrays)
    np.testing.assert_array_equal(recording.time, np.arange(written.n) * 2_000_000 / 1e9)
    assert recording.velocity is None
    assert recording.rig == rig
    assert recording.run == run.model_copy(update={"exit_status": 0, "reason": "trajectory done"})
    assert recording.complete
    assert recording.gaps.tolist() == [0, 1, 0]
    assert [(event.level, event.source, event.message) for event in recording.events] == [
        ("info", "drives", "enabled"),
        ("warning", "cycle", "Überlänge: missed 1"),
        ("error", "cycles", "bus: missed 2"),
    ]
    assert recording.events[0].time == -1.0


def test_file_of_another_program_is_known_without_reading_its_messages(
    written: SimpleNamespace, tmp_path: Path
) -> None:
    assert not is_foreign(written.path)
    assert is_foreign(SAMPLES / "foreign" / "joint_states_0.mcap")
    path = tmp_path / "other.mcap"
    for chunked in (False, True):
        by_others(path, *1000 * [bytes(5000)], chunked=chunked)
        assert is_foreign(path)
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
        assert is_foreign(path), "an interrupted one"
    path.write_bytes(b"no MCAP")
    with pytest.raises(BadInput, match="not an MCAP file"):
        is_foreign(path)


MESSAGES = st.lists(
    st.tuples(
        st.sampled_from(["joint_states", "joint_commands", "amplifiers"]),
        st.integers(0, 12),
        st.lists(st.floats(allow_nan=False), min_size=3, max_size=3),
    ),
    min_size=1,
    max_size=40,
    unique_by=lambda message: message[:2],
)


@given(MESSAGES, st.integers(1, 10**9))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_messages_of_one_sync_are_joined_in_any_order_and_with_any_of_them_missing(
    tmp_path: Path, run: Run, messages: list[tuple[str, int, list[float]]], period: int
) -> None:
    path = tmp_path / "r.mcap"
    path.unlink(missing_ok=True)
    with RecordingWriter(path, EMPTY_RIG, run) as writer:
        for log, (method, k, values) in enumerate(messages):
            stamp = START + k * period
            if method == "amplifiers":
                writer.amplifiers(stamp, log, k, k, 0.5, values, (k, k, k), (1, 2, k))
            else:
                getattr(writer, method)(stamp, log, values)
    recording = read(path)
    given_values = {(method, k): values for method, k, values in messages}
    cycles = sorted({k for _, k, _ in messages})
    np.testing.assert_array_equal(recording.time, (np.array(cycles) - cycles[0]) * period / 1e9)
    gap = [np.nan] * 3
    columns = (recording.position, recording.command, recording.voltage)
    for method, column in zip(("joint_states", "joint_commands", "amplifiers"), columns, strict=True):
        np.testing.assert_array_equal(column, [given_values.get((method, k), gap) for k in cycles])
    answered = [("amplifiers", k) in given_values for k in cycles]
    np.testing.assert_array_equal(recording.repeat, np.where(answered, cycles, -1))
    np.testing.assert_array_equal(recording.lateness, np.where(answered, 0.5, np.nan))
    np.testing.assert_array_equal(recording.statusword[:, 1], np.where(answered, cycles, 0))
    np.testing.assert_array_equal(recording.error_code[:, 0], np.where(answered, 1, 0))


def test_velocity_and_effort_are_gaps_until_first_measured(tmp_path: Path, rig: Rig, run: Run) -> None:
    with RecordingWriter(tmp_path / "r.mcap", rig, run) as writer:
        writer.joint_states(0, 0, (1, 2, 3))
        writer.joint_states(1, 1, (1, 2, 3), velocity=(4, 5, 6))
        writer.joint_states(2, 2, (1, 2, 3), velocity=(7, 8, 9), effort=(1, 1, np.nan))
    recording = read(tmp_path / "r.mcap")
    np.testing.assert_array_equal(recording.velocity, [[np.nan] * 3, [4, 5, 6], [7, 8, 9]])
    np.testing.assert_array_equal(recording.effort, [[np.nan] * 3, [np.nan] * 3, [1, 1, np.nan]])


@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_flipped_bit_is_detected_or_harmless(tmp_path: Path, written: SimpleNamespace, data: st.DataObject) -> None:
    spoiled = bytearray(written.path.read_bytes())
    spoiled[data.draw(st.integers(0, len(spoiled) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path / "spoiled.mcap"
    path.write_bytes(spoiled)
    try:
        recording = read(path)
    except BadInput:
        return
    assert_same(recording, written, "position", "voltage")
    assert recording.complete


def by_others(
    path: Path,
    *messages: bytes,
    topic: str = "/imu",
    encodings: tuple[str, str] = ("cdr", "ros2msg"),
    chunked: bool = True,
    rig: bool = False,
) -> None:
    """A file of another program, with the library's own writer; with the description of a `rig`, if told so."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.NONE, use_chunking=chunked)
        writer.start()
        schema = writer.register_schema("std_msgs/msg/Byte", encodings[1], b"byte data")
        channel = writer.register_channel(topic, encodings[0], schema)
        for k, message in enumerate(messages):
            writer.add_message(channel, k, message, k)
        if rig:
            writer.add_metadata("rig", rig_record(EMPTY_RIG))
            writer.add_metadata("run", {"software": "theirs"})
        writer.finish()


BYTE = b"\x00\x01\x00\x00\x01"


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda path: None, "does not exist; check the path"),
        (lambda path: path.mkdir(), "a file expected, a folder found"),
        (lambda path: path.touch(), "is empty"),
        (
            lambda path: path.write_bytes(b"time,position_1\n0,1\n"),
            "is not an MCAP file; .* ident.read",
        ),
        (
            lambda path: path.write_bytes(b"\xff\xd8\xff\xe0\x00\x10JFIF"),
            "is not an MCAP file, but a JPEG picture; .* ident.read",
        ),
        (
            lambda path: path.write_bytes(b"\x89MCAP0\r\n"),
            "cut off before its first data; if another program wrote it",
        ),
        (lambda path: by_others(path, BYTE), "not a recording of this program: .* rig, run, /joint_states"),
        (lambda path: by_others(path, BYTE, rig=True), "not a recording of this program: .* /joint_states"),
        (lambda path: by_others(path, BYTE, topic="/joint_states"), "not a recording of this program"),
        (
            lambda path: by_others(path, b"{}", topic="/joint_states", encodings=("json", "jsonschema")),
            "not a recording of this program: .*json and jsonschema found",
        ),
    ],
)
def test_error_for_other_files_names_their_kind(tmp_path: Path, make: Callable[[Path], object], reason: str) -> None:
    path = tmp_path / "r.mcap"
    make(path)
    with pytest.raises(BadInput, match=reason):
        read(path)


def rewritten(
    path: Path, rig: dict[str, str], run: dict[str, str], texts: dict[str, str], names: str = "123"
) -> None:
    """A recording of one SYNC by another hand: uncompressed, joints in another order, and what the caller spoils."""
    header = {"stamp": {"sec": 1, "nanosec": 0}}
    joints = [f"joint_{name}" for name in names]
    state = {"header": header, "name": joints, "position": [float(name) for name in names]}
    amplifiers = {"header": header, "voltage": [1.0, 2.0, 3.0], "statusword": [1, 2, 3], "error_code": [0, 0, 0]}
    with path.open("wb") as stream, Ros2Writer(stream, compression=CompressionType.LZ4) as writer:
        writer.add_metadata("rig", rig)
        writer.add_metadata("run", run)
        for topic, (name, text) in schemas.TOPICS.items():
            schema = writer.register_msgdef(name, texts.get(topic, text))
            message = {"/amplifiers": amplifiers, "/events": {"msg": "hello"}}.get(topic, state)
            writer.write_message(topic, schema, message, 10**9)


@pytest.fixture
def records(run: Run) -> tuple[dict[str, str], dict[str, str]]:
    return rig_record(EMPTY_RIG), run_record(run)


def test_joints_are_ordered_by_name_and_unknown_fields_are_ignored(
    tmp_path: Path, records: tuple[dict[str, str], dict[str, str]]
) -> None:
    main, rest = schemas.AMPLIFIER_STATE.split("=" * 80, 1)
    grown = f"{main}float32[] temperature\n{'=' * 80}{rest}"
    rewritten(tmp_path / "r.mcap", *records, {"/amplifiers": grown}, names="312")
    recording = read(tmp_path / "r.mcap")
    assert recording.position.tolist() == recording.command.tolist() == [[1.0, 2.0, 3.0]]
    assert recording.voltage.tolist() == [[1.0, 2.0, 3.0]]
    assert recording.events[0].message == "hello"
    assert recording.rig == EMPTY_RIG


@pytest.mark.parametrize(
    ("spoil", "names", "reason"),
    [
        (lambda rig, run, texts: rig.update(layout="2"), "123", "layout 1 expected, 2 found; .* wrote it"),
        (lambda rig, run, texts: rig.update(json="{"), "123", "'rig' is not valid JSON"),
        (lambda rig, run, texts: rig.update(json='{"rate": 5.0}'), "123", "key 'name' is missing"),
        (lambda rig, run, texts: run.pop("rate"), "123", "'run': rate: Field required"),
        (lambda rig, run, texts: run.update(simulated="perhaps"), "123", "'run': simulated: "),
        (
            lambda rig, run, texts: texts.update(
                {"/amplifiers": schemas.AMPLIFIER_STATE.replace("float64 lateness", "float32 lateness")}
            ),
            "123",
            "/amplifiers with lateness expected",
        ),
        (lambda rig, run, texts: None, "12", "3 joints expected in position of /joint_states, 2 found"),
        (lambda rig, run, texts: None, "124", "joint_3 expected, .*joint_4"),
    ],
)
def test_recordings_of_another_layout_are_refused(
    tmp_path: Path,
    records: tuple[dict[str, str], dict[str, str]],
    spoil: Callable[[dict[str, str], dict[str, str], dict[str, str]], object],
    names: str,
    reason: str,
) -> None:
    texts: dict[str, str] = {}
    spoil(*records, texts)
    rewritten(tmp_path / "r.mcap", *records, texts, names)
    with pytest.raises(BadInput, match=reason):
        read(tmp_path / "r.mcap")


def test_run_without_samples_reports_its_reason(tmp_path: Path, rig: Rig, run: Run) -> None:
    path = tmp_path / "r.mcap"
    with RecordingWriter(path, rig, run) as writer:
        writer.event(0, "error", "drives", "drive 2 does not answer")
        writer.close(1, "drive 2 does not answer")
    with pytest.raises(BadInput, match="holds no samples, the run ended before: drive 2 does not answer"):
        read(path)
    assert len(read_can(path).id) == 0
