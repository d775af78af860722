"""One recording becomes rows; one that cannot be used becomes a row with the reason."""

from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from ident.fleet.recording_rows import Row, examine, motion_features, start_of
from ident.fleet.settings import FleetSettings
from ident.fleet.walk import walk
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import simulated_rig


def examined(folder: Path) -> list[Row]:
    (file,) = walk([folder])
    return examine(file, FleetSettings())


def test_rows_hold_the_parameters_within_their_intervals(
    tmp_path: Path, night: Callable[..., Path], truth: Floats
) -> None:
    night(tmp_path / "a.mcap", 3)
    about, *values = examined(tmp_path)
    assert (about["status"], about["robot"], about["start"]) == ("done", "r01", datetime(2026, 1, 8, 22, tzinfo=UTC))
    by_name = {row["name"]: row for row in values}
    friction = by_name["c_c2"]
    assert (friction["kind"], friction["joint"], friction["unit"]) == ("parameter", 2, "N m")
    expected = truth[9]
    assert abs(friction["value"] - expected) < 3 * (friction["high"] - friction["low"])
    assert by_name["m_p"]["joint"] is None
    assert {row["joint"] for row in values if row["kind"] == "error"} == {1, 2, 3}
    assert all(row["key"] == about["key"] for row in values)


def test_robot_without_a_name_of_its_own_has_that_of_the_rig(tmp_path: Path, night: Callable[..., Path]) -> None:
    night(tmp_path / "a.mcap", 1, robot=None)
    assert examined(tmp_path)[0]["robot"] == simulated_rig().name


@pytest.mark.parametrize("content", [b"", b"no recording\n", bytes(range(256)) * 8])
def test_broken_file_is_one_row_with_its_reason(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    (row,) = examined(tmp_path)
    assert row["status"] == "failed"
    assert "a.mcap" in row["reason"]
    assert "\n" not in row["reason"]


def test_unset_clock_is_a_row_that_still_has_the_robot(tmp_path: Path, night: Callable[..., Path]) -> None:
    night(tmp_path / "a.mcap", 1, start="1970-01-01T00:00:00Z")
    (row,) = examined(tmp_path)
    assert (row["status"], row["robot"]) == ("failed", "r01")
    assert "1970-01-01" in row["reason"]


def test_data_that_cannot_be_right_are_one_row_with_that_reason(
    tmp_path: Path, night: Callable[..., Path], write: Callable[[Recording], Path]
) -> None:
    right = read(night(tmp_path / "a.mcap", 1))
    right.path.unlink()
    write(replace(right, voltage=right.voltage * [-1, 1, 1]))
    (row,) = examined(tmp_path)  # no value, and so no alarm
    assert (row["status"], row["robot"]) == ("failed", "r01")
    assert "torque-sign: The torque of joint 1 has the other sign" in row["reason"]


def test_start_is_read_with_any_zone_and_a_future_one_is_refused(recording: Recording) -> None:
    run = recording.run
    start = start_of(run.model_copy(update={"start": "2026-03-14T01:00:00+02:00"}))
    assert start == datetime(2026, 3, 13, 23, tzinfo=UTC)
    for text in ("2999-01-01T00:00:00Z", "yesterday", "1970-01-01T05:00:00"):
        with pytest.raises(BadInput):
            start_of(run.model_copy(update={"start": text}))


def test_motion_features_are_blind_to_an_encoder_that_slipped(make: Callable[..., Recording]) -> None:
    first, other = make("fig5a"), make("fig5b")
    features = motion_features(first)
    first.position[:] += 0.2
    assert np.allclose(motion_features(first), features)
    assert not np.allclose(motion_features(other), features, rtol=0.02)
