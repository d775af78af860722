"""`daq info` on complete, interrupted and invalid recordings."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from daq.commands.info import command
from recordings.recording import Recording
from recordings.rig import simulated_rig
from recordings.writer import RecordingWriter
from tests.made_up import run_of
from tests.running import invoke, printed

Record = Callable[..., Path]


@pytest.fixture
def record(tmp_path: Path) -> Record:
    """Write a recording of 101 SYNCs with a gap, frames and events."""

    def write(
        simulated: bool = True,
        exit_status: int = 0,
        robot: str | None = None,
        stopped: int | None = None,
        period: float = 0.1,
    ) -> Path:
        run = run_of(period=period, pace="realtime", simulated=simulated, robot=robot)
        path = tmp_path / "run.mcap"
        with RecordingWriter(path, simulated_rig(), run) as writer:
            for k in range(101):
                stamp = k * 2_000_000
                writer.can(stamp, stamp, 0x80, b"", sent=True)
                for node in (1, 2, 3):
                    writer.can(stamp, stamp, 0x180 + node, bytes(8), sent=False)
                writer.joint_states(stamp, stamp, (0.1, np.nan if k == 7 else 0.2, 0.3))
                writer.joint_commands(stamp, stamp, (0.1, 0.2, 0.3))
                if k == stopped:
                    writer.event(stamp, "error", "daq", "a fault")
                writer.amplifiers(stamp, stamp, k, 0, k * 1e-5, (1.0, 2.0, 3.0), (7, 7, 7), (0, 0, 0))
            writer.event(stamp, "info", "daq", "all is well")
            writer.event(stamp, "warning", "daq", "[bold]missed[/bold] a cycle")
            writer.close(exit_status, "following error of joint 2" if exit_status else "done")
        return path

    return write


def test_motion_without_repetitions_has_no_cycles(record: Record) -> None:
    assert "cycles: none found\n" in printed(command, record(period=0.0))


def test_json_output_holds_exactly_the_figures(record: Record) -> None:
    path = record()
    assert json.loads(printed(command, path, "--json")) == {
        "schema": 1,
        "file": str(path),
        "rig": "simulated delta robot",
        "robot": None,
        "position_units": ["rad", "rad", "rad"],
        "simulated": True,
        "pace": "realtime",
        "seed": None,
        "software": "0.1.0",
        "start": "2023-11-14T22:13:20+00:00",
        "trajectory": "fig5a",
        "trajectory_digest": "d1f0",
        "feedforward": None,
        "rate_hz": 500.0,
        "cycles": 2,
        "period_s": 0.1,
        "duration_s": 0.2,
        "samples": 101,
        "gaps": [0, 1, 0],
        "longest_gap_s": 0.0,
        "following_error_rms": [0.0, 0.0, 0.0],
        "following_error_max": [0.0, 0.0, 0.0],
        "lateness_s": {"p50": pytest.approx(5e-4), "p99": pytest.approx(9.9e-4), "max": pytest.approx(1e-3)},
        "lateness_histogram": [
            {"up_to_s": pytest.approx(step), "cycles": cycles}
            for step, cycles in ((1e-5, 2), (2e-5, 1), (5e-5, 3), (1e-4, 5), (2e-4, 10), (5e-4, 30), (1e-3, 50))
        ],
        "frames": {"sent": 101, "received": 303},
        "events": [
            {"time_s": 0.2, "level": "warning", "source": "daq", "message": "[bold]missed[/bold] a cycle"},
        ],
        "complete": True,
        "exit_status": 0,
        "reason": "done",
    }


def test_piped_output_is_plain_lines(record: Record) -> None:
    path = record(robot="press 4")
    result = invoke(command, path)
    assert result.stderr == f"next: ident check {path}\n"
    assert {
        "robot: press 4",
        "drives: simulated: no real robot moved",
        "gaps: joint 1: 0, joint 2: 1, joint 3: 0",
        "lateness: p50 0.500 ms, p99 0.990 ms, max 1.000 ms",
        "  up to 0.2 ms:     10 ████████",
        "  up to 1 ms:     50 " + 40 * "█",
        "bus frames: 101 sent, 303 received",
        "warning: 0.200 s daq: [bold]missed[/bold] a cycle",
        "ended: done, exit status 0: done",
    } <= set(result.stdout.splitlines())


def test_following_error_is_that_of_the_run(record: Record, monkeypatch: pytest.MonkeyPatch) -> None:
    error = np.full((101, 3), np.nan)
    monkeypatch.setattr(Recording, "following_error", error)
    path = record()
    figures = json.loads(printed(command, path, "--json"))
    assert (figures["following_error_rms"], figures["following_error_max"]) == (None, None)
    assert "\nfollowing error" not in printed(command, path), "there were no commands"
    error[:3] = [[np.nan, 0.0, 0.0], [0.003, -0.004, np.nan], [0.004, 0.0, 0.0]]
    figures = json.loads(printed(command, path, "--json"))
    assert figures["following_error_max"] == [0.004, 0.004, 0.0]
    assert figures["following_error_rms"] == pytest.approx([np.sqrt(12.5e-6), np.sqrt(16e-6 / 3), 0.0])
    assert "following error: joint 1: 3.54 (worst 4.00) mrad, joint 2" in printed(command, path)


def test_following_error_of_a_failed_run_is_that_before_its_stop(
    record: Record, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = np.full((101, 3), 0.001)
    error[90:] = 0.5  # the arms fall
    monkeypatch.setattr(Recording, "following_error", error)
    path = record(exit_status=1, stopped=90)
    figures = json.loads(printed(command, path, "--json"))
    assert figures["complete"] is False
    assert figures["following_error_max"] == [0.001] * 3
    assert invoke(command, path).stderr.startswith("next: ident check")


def test_real_drives_and_failure_are_shown(record: Record) -> None:
    output = printed(command, record(simulated=False, exit_status=1))
    assert "SIMULATED" not in output
    assert "ended: FAILED, exit status 1: following error of joint 2" in output


def test_interrupted_recording_is_shown_as_interrupted(record: Record, tmp_path: Path) -> None:
    whole = record().read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: whole.rindex(b"exit_status")])
    result = invoke(command, path)
    assert "ended: INTERRUPTED" in result.stdout
    assert result.stderr == f"next: daq recover {path}\n"
    assert "samples: 101" in result.stdout
    figures = json.loads(printed(command, path, "--json"))
    assert (figures["complete"], figures["exit_status"], figures["reason"]) == (False, None, None)
