"""Small motions: what a release, a fault and a runaway are taken for."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from daq.bench import Bench
from daq.commissioning.small_motion import Moved, move
from daq.cycle import session
from recordings.errors import RunFailed
from recordings.rig import HomedBit, simulated_rig
from tests.daq.commissioning.test_axis_check import as_recording
from trajectories import Trajectory
from trajectories.multisine import middle_pose
from trajectories.small_moves import jog

RIG = simulated_rig().at_rate(100.0)


def released(out: Path | None = None) -> Moved:
    """A jog whose key is released before it begins."""
    reading, writing = os.pipe()
    os.close(writing)
    try:
        return move(
            Bench.of(RIG, None, None),
            lambda pose: jog(RIG, pose, 1, 0.05),
            out,
            lambda *line: None,
            hold=reading,
            status=False,
        )
    finally:
        os.close(reading)


def test_release_is_no_failure_and_the_recording_is_kept_where_asked(tmp_path: Path) -> None:
    moved = released(tmp_path / "jog.mcap")
    assert moved.released
    assert moved.recording.run.exit_status == 1
    assert (tmp_path / "jog.mcap").exists()


def test_joint_that_does_not_follow_is_no_success() -> None:
    moved = move(Bench.of(RIG, None, None), lambda pose: jog(RIG, pose, 1, 0.05), None, lambda *line: None)
    moved.refuse_laggard(1, "rad")
    recording = moved.recording
    position = recording.position[:1] + 0.7 * (recording.position - recording.position[:1])
    with pytest.raises(
        RunFailed, match=r"joint 1 does not follow: it moved by \+0\.035\d of \+0\.0500 rad; .*counts_"
    ):
        replace(moved, recording=replace(recording, position=position)).refuse_laggard(1, "rad")


def test_run_that_ends_before_the_first_sample_says_why(tmp_path: Path) -> None:
    (tmp_path / "sim.toml").write_text("[[drives]]\n[drives.habits]\nreferenced = false\n")
    homed = HomedBit(index=0x6041, mask=0x8000)
    drives = tuple(drive.model_copy(update={"homed": homed}) for drive in RIG.drives)
    machine = Bench.of(RIG.model_copy(update={"drives": drives}), None, tmp_path / "sim.toml")
    with pytest.raises(RunFailed, match="home the drive first"):
        move(machine, lambda pose: jog(RIG, pose, 1, 0.05), None, lambda *line: None, hold=None, status=False)


def test_fault_beside_a_release_is_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    run = session.Session.run

    def fail(self: session.Session, display: session.Display) -> session.Result:
        try:
            return run(self, display)
        except RunFailed as error:
            raise RunFailed(f"{error}; NOT CONFIRMED DISABLED: joint 1") from None

    monkeypatch.setattr(session.Session, "run", fail)
    moved = released()
    assert not moved.released
    assert "NOT CONFIRMED" in (moved.error or "")


def test_joint_that_runs_away_is_named() -> None:
    motion: Trajectory = jog(RIG, middle_pose(RIG), 1, 0.05)
    recording = as_recording(RIG, motion, np.ones_like(motion.joint_position))
    assert Moved(recording, "following error", False).contradiction(1) == ""
    mirrored = 2 * motion.joint_position[0] - recording.position
    against = replace(recording, position=mirrored)
    assert "runs against its command" in Moved(against, "following error", False).contradiction(1)
