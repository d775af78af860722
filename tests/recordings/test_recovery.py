"""Recovery: the new file holds all intact data and is complete for every reader."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import ChunkIndex

from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.recovery import RewriteSummary, rewrite
from recordings.rig import Rig
from tests.arrays import assert_same

END = {"exit_status": "1", "reason": "recovered"}


def chunks_of(path: Path) -> list[ChunkIndex]:
    """Index of the chunks of a whole recording in the order of the file; the first holds the message types only."""
    with path.open("rb") as stream:
        return sorted(make_reader(stream).get_summary().chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)


def intact_syncs(written: SimpleNamespace, size: int) -> int:
    """SYNCs whose three messages all stand in chunks that end within the first `size` bytes."""
    intact = [chunk for chunk in chunks_of(written.path) if chunk.chunk_start_offset + chunk.chunk_length <= size]
    end = max((chunk.message_end_time for chunk in intact), default=0)
    return int((written.stamp + 700_000 <= end).sum())


@given(st.data(), st.sampled_from([0, 1, 100_000]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=50)
def test_truncated_file_gives_all_intact_chunks_and_is_rewritten_as_complete_file(
    tmp_path: Path, written: SimpleNamespace, data: st.DataObject, zeros: int
) -> None:
    whole = written.path.read_bytes()
    size = data.draw(st.integers(0, len(whole) - 1))
    intact = intact_syncs(written, size)
    cut, out = tmp_path / "cut.mcap", tmp_path / "out.mcap"
    out.unlink(missing_ok=True)
    cut.write_bytes(before := whole[:size] + bytes(zeros))
    try:
        summary = rewrite(cut, out, END)
    except BadInput:
        assert not out.exists()
        with pytest.raises(BadInput, match=r"cut off|is empty|not an MCAP|no samples"):
            read(cut)
        assert not intact
        return
    assert cut.read_bytes() == before
    with out.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        statistics = reader.get_summary().statistics
        assert sum(1 for _ in reader.iter_messages()) == statistics.message_count == summary.messages
        last = list(reader.iter_metadata())[-1]
        assert (last.name, last.metadata) == ("run", END)
    try:
        recording = read(cut)
    except BadInput:  # an event and no sample
        assert not intact
        return
    assert len(recording.time) >= intact
    np.testing.assert_array_equal(recording.position[:intact], written.position[:intact])
    assert recording.complete == (recording.run.reason == "trajectory done")
    recovered = read(out)
    assert_same(recovered, recording, "position", "voltage")
    assert recovered.events == recording.events
    assert (recovered.complete, recovered.run.exit_status, recovered.run.reason) == (True, 1, "recovered")
    assert len(read_can(out).id) == len(read_can(cut).id)


def test_damaged_chunk_is_left_out_and_the_others_kept(tmp_path: Path, written: SimpleNamespace) -> None:
    spoiled = bytearray(written.path.read_bytes())
    middle = chunks_of(written.path)[2]
    spoiled[middle.chunk_start_offset + middle.chunk_length - 100] ^= 0xFF
    summary = recovered_from(bytes(spoiled), tmp_path)
    with pytest.raises(BadInput, match=r"damaged.*daq recover"):
        read(tmp_path / "spoiled.mcap")
    recovered = read(tmp_path / "out.mcap")
    lost = written.n - len(recovered.time)
    length = middle.chunk_length
    assert (summary.lost_chunks, summary.lost_bytes, summary.lost_rows) == (1, length, lost)
    assert (summary.rows, summary.lost_records, summary.altered) == (len(recovered.time), (), False)
    assert 300 < len(recovered.time) < written.n
    kept = np.r_[:50, -50:0]
    np.testing.assert_array_equal(recovered.position[kept], written.position[kept])


def recovered_from(content: bytes, folder: Path, rig: Rig | None = None) -> RewriteSummary:
    """Recover a file of this `content` in `folder` as out.mcap."""
    (folder / "out.mcap").unlink(missing_ok=True)
    (folder / "spoiled.mcap").write_bytes(content)
    return rewrite(folder / "spoiled.mcap", folder / "out.mcap", END, rig=rig)


@pytest.mark.parametrize("text", [b"delta-workbench", b"string frame_id"], ids=["in the data", "in the summary"])
def test_altered_text_beside_the_samples_is_told_by_the_checksums(
    text: bytes, tmp_path: Path, written: SimpleNamespace
) -> None:
    spoiled = written.path.read_bytes().replace(text, text.upper())
    summary = recovered_from(spoiled, tmp_path)
    assert (summary.rows, summary.lost_bytes, summary.lost_records, summary.altered) == (written.n, 0, (), True)


def test_damaged_text_is_told_in_words_of_no_program(tmp_path: Path, written: SimpleNamespace) -> None:
    whole = written.path.read_bytes()
    at = whole.index(b'"mechanism"')
    (tmp_path / "spoiled.mcap").write_bytes(whole[:at] + b"\xec" + whole[at + 1 :])
    with pytest.raises(BadInput, match="is damaged: a record holds something else than it says; restore it"):
        read(tmp_path / "spoiled.mcap")


@pytest.mark.parametrize("name", ["rig", "run"])
def test_lost_record_is_named_and_replaced(name: str, tmp_path: Path, written: SimpleNamespace, rig: Rig) -> None:
    whole = written.path.read_bytes()
    at = whole.index(len(name).to_bytes(4, "little") + name.encode())
    spoiled = whole[: at + 4] + b"xyz" + whole[at + 7 :]
    summary = recovered_from(spoiled, tmp_path)
    assert (summary.lost_records, summary.rows) == ((name,), written.n)
    if name == "rig":
        with pytest.raises(BadInput, match="rig"):
            read(tmp_path / "out.mcap")
        recovered_from((tmp_path / "out.mcap").read_bytes(), tmp_path, rig)
    recording = read(tmp_path / "out.mcap")
    assert recording.rig == rig
    assert len(recording.time) == written.n
    assert (name == "run") == recording.run.drives_in_words.startswith("not known")


def test_message_types_that_are_lost_are_those_of_this_program(tmp_path: Path, written: SimpleNamespace) -> None:
    whole = written.path.read_bytes()
    first = chunks_of(written.path)[0]
    end = first.chunk_start_offset + first.chunk_length
    summary_start = whole.rindex(b"sensor_msgs/msg/JointState", 0, len(whole))
    spoiled = whole[: first.chunk_start_offset + 40] + bytes(end - first.chunk_start_offset - 40)
    summary = recovered_from(spoiled + whole[end : summary_start - 2000], tmp_path)
    assert summary.rows > 0.8 * written.n
    np.testing.assert_array_equal(read(tmp_path / "out.mcap").position[:50], written.position[:50])
