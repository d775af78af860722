"""The recordings of a fleet: each night's own date and robot, broken files as planned, resumed where it ended."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.fleet import plan, record
from drivers.simulated.seal import unseal
from recordings.reader import read


@pytest.mark.slow
def test_one_robot_over_three_nights(tmp_path: Path) -> None:
    drawn = replace(
        plan.draw(1, 1, 3, events=0),
        missing=frozenset({(0, 1)}),
        faults={(0, 2): "truncated"},
        other_motion=frozenset(),
    )
    record.make(tmp_path, drawn)
    first, last = sorted((tmp_path / "r01").iterdir())
    recording = read(first)
    assert (recording.run.robot, recording.run.start[:10]) == ("r01", "2026-01-05")
    assert abs(recording.temperature.mean() - drawn.temperature[0, 0]) < 0.1
    assert last.stat().st_size < first.stat().st_size / 2
    assert unseal(tmp_path / record.SEALED)["broken"] == ["r01:2"]
    first.unlink()
    kept = last.stat().st_mtime_ns
    record.make(tmp_path, drawn)
    assert first.exists()
    assert last.stat().st_mtime_ns == kept


def test_truth_of_an_outside_effect_says_joints_and_variables() -> None:
    events = record.truth(plan.draw(1, 6, 20, 6, outside=True))["events"]
    assert isinstance(events, list)
    cables = next(event for event in events if event["effect"] == "tangled_cables")
    assert cables["joint"] in cables["joints"]
    assert set(cables["outside"]) == {"position", *(f"joint_{joint}" for joint in cables["joints"])}
    assert all("outside" not in event for event in record.truth(plan.draw(1, 6, 20, 6))["events"])  # type: ignore[attr-defined]
