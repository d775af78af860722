"""Recovery: the new file holds all intact data and is complete for every reader."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.recovery import rewrite
from tests.arrays import assert_same

END = {"exit_status": "1", "reason": "recovered"}


def intact_syncs(written: SimpleNamespace, size: int) -> int:
    """SYNCs whose three messages all stand in chunks that end within the first `size` bytes."""
    with written.path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    intact = [chunk for chunk in chunks if chunk.chunk_start_offset + chunk.chunk_length <= size]
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
    kept = np.r_[:50, -50:0]
    np.testing.assert_array_equal(recovered.position[kept], written.position[kept])
