"""Status lines of the recording process."""

import sys
import time
from pathlib import Path

import pytest

from ident.workbench.pages.live import run_summary
from ident.workbench.recording_process import RecordingProcess, RunStatus
from ident.workbench.topics import Changes
from recordings.errors import BadInput

SLIDE = """
name = "slide"
mechanism = "axes"

[torque]
map = "linear"
gain = [1.0]

[[axes]]
type = "prismatic"

[[drives]]
node_id = 1
"""


def run(folder: Path, monkeypatch: pytest.MonkeyPatch, program: str, **options: str) -> RunStatus:
    """Return the status after a run of a `daq` that executes `program`."""
    command = [sys.executable, "-c", program]
    monkeypatch.setattr("ident.workbench.recording_process.daq_command", lambda: command)
    process = RecordingProcess(folder, Changes())
    process.mark_seen()
    process.start({f"--{name}": value for name, value in options.items()}, folder / "run.mcap")
    assert process.run
    deadline = time.monotonic() + 60
    while process.run.exit_code is None:
        assert time.monotonic() < deadline, "timeout"
        time.sleep(0.02)
    return process.run


def test_lines_without_lateness_and_other_text_do_not_end_the_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = ('{"rows": [{"time": 1.0}]}', "no JSON", '{"rows": [{"time": 2.0}], "lateness": 0.5, "done": 3}')
    status = run(tmp_path, monkeypatch, f"print(*{lines!r}, sep=chr(10))")
    assert [row["time"] for row in status.rows] == [1.0, 2.0]
    assert list(status.lateness) == [(2.0, 0.5)]
    assert status.status["done"] == 3
    assert status.exit_code == 0


def test_units_of_positions_come_from_the_rig_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "slide.toml").write_text(SLIDE)
    assert run(tmp_path, monkeypatch, "", rig="slide.toml").position_unit == "m"
    assert run(tmp_path, monkeypatch, "").position_unit == "rad"


def test_invalid_rig_file_is_refused_before_anything_starts(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("nonsense = 1")
    process = RecordingProcess(tmp_path, Changes())
    with pytest.raises(BadInput, match=r"bad\.toml"):
        process.start({"--rig": "bad.toml"}, tmp_path / "run.mcap")
    assert process.run is None


def test_wrong_option_is_told_without_raw_usage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [
        "Usage: daq record [OPTIONS]",
        "Try 'daq record --help' for help.",
        "",
        "Error: '--cycles': -3 is too small.",
    ]
    status = run(tmp_path, monkeypatch, f"import sys; print(*{lines!r}, sep=chr(10), file=sys.stderr); sys.exit(2)")
    assert list(status.messages) == ["error: '--cycles': -3 is too small."]
    assert run_summary(status) == "run.mcap: did not start. error: '--cycles': -3 is too small."
