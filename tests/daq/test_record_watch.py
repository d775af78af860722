"""`daq record --watch`: another process reads the file, its alarm is an event, and stops the run only if asked to."""

import json
import sys
from pathlib import Path

import pytest

import daq.watch
from recordings.reader import read
from tests.conftest import Runner

MOTION = ("--traj", "fig5b", "--cycles", 1, "--rate", 100)
ALARM = {"joints": [2], "since": 0.1, "kind": "sudden"} | {
    "effect": "stribeck",
    "confusable_with": [],
    "evidence": 412.0,
}
SCRIPT = f"""
import json, sys
assert sys.argv[1:] == ["watch", "m.json", "run.mcap", "--follow", "--samples", "50"], sys.argv
print(json.dumps({{"time": 0.5, "alarm": {ALARM!r}}}), flush=True)
"""
"""In place of `ident`: raises an alarm at once."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "m.json").write_text("{}")
    return tmp_path


def stand_in(monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    monkeypatch.setattr(daq.watch, "IDENT", (sys.executable, "-c", script))


def test_alarm_alone_is_an_event(daq_in_process: Runner, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(monkeypatch, SCRIPT)
    run = daq_in_process("record", *MOTION, "--watch", "m.json", "--out", "run.mcap", "--status")
    assert run.code == 0, run.err
    recording = read(folder / "run.mcap")
    (event,) = (event for event in recording.events if event.source == "watch")
    assert (event.level, json.loads(event.message.removeprefix("alarm: "))) == ("warning", ALARM)
    assert recording.run.exit_status == 0
    told = [json.loads(line) for line in run.out.splitlines()]
    assert [line["watch"]["alarm"] for line in told if "watch" in line] == [ALARM]


def test_alarm_stops_as_an_operator_would(
    daq_in_process: Runner, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, SCRIPT)
    run = daq_in_process("record", *MOTION, "--watch", "m.json", "--stop-on-alarm", "--out", "run.mcap")
    assert run.code == 3
    assert "stopped by alarm" in run.err
    recording = read(folder / "run.mcap")
    assert recording.run.exit_status == 3
    assert recording.run.reason is not None
    assert "stribeck" in recording.run.reason
    assert "STOPPED, exit status 3" in daq_in_process("info", "run.mcap").out


def test_watch_that_fails_leaves_the_run_alone(
    daq_in_process: Runner, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(monkeypatch, "import sys; sys.exit('error: no such model')")
    run = daq_in_process("record", *MOTION, "--watch", "m.json", "--stop-on-alarm", "--out", "run.mcap")
    assert run.code == 0, run.err
    assert "the watch ended: error: no such model" in run.err
