"""`daq recover` on interrupted, damaged, listened and complete recordings."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from daq.commands.recover import command
from daq.passive.recover import recover, recover_in_place
from recordings.errors import BadInput, RunFailed
from recordings.reader import is_foreign, read, read_can
from tests.daq.passive.listening import SAMPLE, arrivals, sample_frames, write

FOREIGN = SAMPLE.parent / "foreign" / "joint_states_0.mcap"


@pytest.fixture
def cut(tmp_path: Path) -> Path:
    """The sample recording, cut off after two thirds as by a killed program."""
    whole = SAMPLE.read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: len(whole) * 2 // 3])
    return path


def test_file_is_replaced_only_with_in_place(cut: Path) -> None:
    expected = read(cut).position
    cut.with_name("cut.mcap.part").write_text("rest of a killed recovery")
    recover_in_place(cut)
    assert read(cut).complete
    np.testing.assert_array_equal(read(cut).position, expected)
    assert list(cut.parent.iterdir()) == [cut]


def test_samples_of_a_killed_listener_are_reconstructed(tmp_path: Path) -> None:
    """The file holds frames only; the samples must equal those of the replayed recording."""
    sample, frames = read(SAMPLE), sample_frames()
    write(tmp_path / "whole.mcap", sample.rig, frames, arrivals(frames, 4e6, 0))
    whole = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "killed.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInput, match="daq recover"):
        read(tmp_path / "killed.mcap")
    recovered = recover(tmp_path / "killed.mcap", tmp_path / "out.mcap")
    assert recovered.reconstructed
    recording = read(tmp_path / "out.mcap")
    count = len(recording.time)
    assert 500 < count < len(sample.time)
    np.testing.assert_allclose(recording.position[:-1], sample.position[: count - 1], rtol=0, atol=1e-15)
    assert (recording.run.exit_status, recording.run.rate) == (1, 250.0)
    described = 2  # the robot, and what of it never moves
    assert len(read_can(tmp_path / "out.mcap").id) == recovered.kept.messages - described


def test_listened_recording_without_sync_is_not_recovered_and_stays_as_it_is(tmp_path: Path) -> None:
    frames, path = sample_frames(), tmp_path / "r.mcap"
    write(path, read(SAMPLE).rig, frames, arrivals(frames, 4e6, 0), frames.id == 0x181)
    before = path.read_bytes()
    with pytest.raises(RunFailed, match=rf"no SYNC was heard, so {path} holds"):
        recover_in_place(path)
    with pytest.raises(RunFailed, match="no SYNC"):
        recover(path, tmp_path / "out.mcap")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_unrecoverable_files_are_rejected_and_leave_no_partial_file(cut: Path, tmp_path: Path) -> None:
    (tmp_path / "noise.mcap").write_text("noise")
    (tmp_path / "head.mcap").write_bytes(cut.read_bytes()[:300])
    for source, reason in (
        (SAMPLE, "is whole; there is nothing to recover"),
        (FOREIGN, "is whole; there is nothing to recover"),
        (tmp_path / "none.mcap", "does not exist"),
        (tmp_path / "noise.mcap", "not an MCAP file"),
        (tmp_path / "head.mcap", "no intact data"),
    ):
        with pytest.raises(BadInput, match=reason):
            recover(source, tmp_path / "out.mcap")
        assert not (tmp_path / "out.mcap").exists()


def test_interrupted_recording_becomes_complete_and_the_command_says_what_was_kept(cut: Path, tmp_path: Path) -> None:
    before, expected = cut.read_bytes(), read(cut)
    assert not expected.complete
    result = CliRunner().invoke(command, [str(cut)], catch_exceptions=False)
    assert f"recovered {cut.with_suffix('.recovered.mcap')}" in result.stdout
    assert "lost: an unknown number of samples, 0 chunks, " in result.stdout
    assert cut.read_bytes() == before
    recovered = read(cut.with_suffix(".recovered.mcap"))
    assert (recovered.run.exit_status, recovered.run.reason) == (1, "recovered after interruption")
    np.testing.assert_array_equal(recovered.position, expected.position)
    out = str(tmp_path / "b.mcap")
    figures = json.loads(CliRunner().invoke(command, [str(cut), "--out", out, "--json"]).stdout)
    assert figures["out"] == out
    assert figures["rows"] == len(expected.time)
    assert figures["lost"]["rows"] is None
    assert figures["lost"]["bytes"] > 1000
    assert (figures["lost"]["chunks"], figures["lost"]["records"]) == (0, [])


def test_cut_file_of_another_program_keeps_its_messages_and_becomes_no_recording(tmp_path: Path) -> None:
    content, path, out = FOREIGN.read_bytes(), tmp_path / "a.mcap", tmp_path / "a.recovered.mcap"
    path.write_bytes(content[: len(content) // 2])
    result = CliRunner().invoke(command, [str(path)], catch_exceptions=False)
    kept, lost, *_ = result.stdout.splitlines()
    assert 1000 < int(kept.split()[1]) < 2840
    assert (kept.split()[2], lost) == ("messages", "lost: an unknown number of messages, 0 chunks, 0 bytes")
    assert result.stderr.strip() == f"next: daq import {out} --out {out.with_suffix('.imported.mcap')}"
    assert is_foreign(out)
    figures = CliRunner().invoke(command, [str(path), "--in-place", "--json"], catch_exceptions=False).stdout
    assert (json.loads(figures)["foreign"], json.loads(figures)["rows"]) == (True, int(kept.split()[1]))
