"""`daq record --status`: status lines for another program."""

import json
import subprocess
from pathlib import Path

from recordings.reader import read
from tests.conftest import Runner, launcher
from tests.patience import patient


def test_status_lines_match_the_recording_and_end_with_the_figures(daq_in_process: Runner, tmp_path: Path) -> None:
    (tmp_path / "sim.toml").write_text('[[drives]]\n[drives.habits]\ntrouble = "long_tpdo"\n')
    motion = ("--traj", "fig5a", "--cycles", 1, "--rate", 100, "--sim", "sim.toml")
    done = daq_in_process("record", *motion, "--status", "--out", "a.mcap")
    assert done.code == 0, done.err
    *lines, figures = map(json.loads, done.out.splitlines())
    assert figures["recording"] == "a.mcap"
    assert {"approach", "stream"} <= {line["status"] for line in lines}
    reports = [text for line in lines for text in line["reports"] if "9 bytes, 8 are mapped" in text]
    assert [text.split(" (")[0] for text in reports] == [f"warning: bus: joint {joint}" for joint in (1, 2, 3)]
    rows = [row for line in lines for row in line["rows"]]
    times = [row["time"] for row in rows]
    assert times == sorted(times)
    recording = read(tmp_path / "a.mcap")
    row = rows[len(rows) // 2]
    sample = round(row["time"] * recording.run.rate)
    assert row["position"] == recording.position[sample].tolist()
    assert row["voltage"] == recording.voltage[sample].tolist()
    errors = [abs(error) for row in rows for error in row["following_error"] if error is not None]
    assert 0 < max(errors) <= figures["following_error_max"], "the supervisor's own error"


def test_run_stops_when_the_reader_has_exited(tmp_path: Path) -> None:
    command = ["record", "--traj", "fig5a", "--cycles", "150", "--rate", "100", "--status", "--out", "a.mcap"]
    process = subprocess.Popen([*launcher("daq"), *command], cwd=tmp_path, stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.close()
    assert process.wait(timeout=patient(120)) == 1
    recording = read(tmp_path / "a.mcap")
    assert recording.run.exit_status == 1
    assert "SIGTERM" in str(recording.run.reason)
    assert recording.repeat.max() < 149
