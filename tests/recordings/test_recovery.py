"""Recovery: the new file holds all intact data and is complete for every reader."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from recordings.blocks import SampleTable
from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.recording import Run
from recordings.recovery import rewrite
from recordings.rig import Rig
from recordings.writer import RecordingWriter

END = {"exit_status": "1", "reason": "recovered"}


@given(st.data(), st.sampled_from([0, 1, 5000]))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=50)
def test_truncated_file_is_rewritten_as_complete_file(
    tmp_path: Path, written: SimpleNamespace, data: st.DataObject, zeros: int
) -> None:
    whole = written.path.read_bytes()
    cut, out = tmp_path / "cut.mcap", tmp_path / "out.mcap"
    out.unlink(missing_ok=True)
    cut.write_bytes(whole[: data.draw(st.integers(0, len(whole) - 1))] + bytes(zeros))
    before = cut.read_bytes()
    try:
        summary = rewrite(cut, out, END)
    except BadInput:
        assert not out.exists()
        with pytest.raises(BadInput):
            read(cut)
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
        return
    recovered = read(out)
    np.testing.assert_array_equal(recovered.position, recording.position)
    np.testing.assert_array_equal(recovered.voltage, recording.voltage)
    assert recovered.events == recording.events
    assert (recovered.complete, recovered.run.exit_status, recovered.run.reason) == (True, 1, "recovered")
    assert len(read_can(out).id) == len(read_can(cut).id)


def test_damaged_chunk_is_left_out_and_the_others_kept(tmp_path: Path, written: SimpleNamespace) -> None:
    spoiled = bytearray(written.path.read_bytes())
    with written.path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    # The first chunk holds the message types only.
    middle = sorted(chunks, key=lambda chunk: chunk.chunk_start_offset)[2]
    spoiled[middle.chunk_start_offset + middle.chunk_length - 100] ^= 0xFF
    (tmp_path / "spoiled.mcap").write_bytes(spoiled)
    with pytest.raises(BadInput, match=r"damaged.*daq recover"):
        read(tmp_path / "spoiled.mcap")
    summary = rewrite(tmp_path / "spoiled.mcap", tmp_path / "out.mcap", END)
    assert summary.damaged_chunks == 1
    recovered = read(tmp_path / "out.mcap")
    assert 300 < len(recovered.time) < written.n
    np.testing.assert_array_equal(recovered.position[:50], written.position[:50])
    np.testing.assert_array_equal(recovered.position[-50:], written.position[-50:])


def test_rewrite_appends_samples(tmp_path: Path, rig: Rig, run: Run) -> None:
    with RecordingWriter(tmp_path / "frames.mcap", rig, run) as writer:
        for stamp in (0, 2_000_000):
            writer.can(stamp, stamp, 0x80, b"", sent=False)
    stamp = np.array([0, 2_000_000])
    added = SampleTable(rig.joint_names, stamp, stamp, np.arange(2), np.zeros(2, np.int64), np.ones((2, 3)))
    rewrite(tmp_path / "frames.mcap", tmp_path / "out.mcap", {"rate": "400.0"}, added)
    recording = read(tmp_path / "out.mcap")
    np.testing.assert_array_equal(recording.position, np.ones((2, 3)))
    assert recording.run.rate == 400.0
    assert len(read_can(tmp_path / "out.mcap").id) == 2
    before = (tmp_path / "out.mcap").read_bytes()
    with pytest.raises(BadInput, match="exists"):
        rewrite(tmp_path / "frames.mcap", tmp_path / "out.mcap", {}, added)
    assert (tmp_path / "out.mcap").read_bytes() == before
