"""Hold-to-run: a jog from the page moves only while its button is held, and says why it ended."""

import re
import sys
import time
from pathlib import Path

import pytest

from ident.workbench.pages.commission import _state
from ident.workbench.recording_process import RecordingProcess, RunStatus
from ident.workbench.topics import Changes
from recordings.errors import BadInput
from tests.ident.workbench.conftest import Browser, Serve

HELD = """
import json, sys
print(json.dumps({"status": "stream", "rows": []}), flush=True)
alive = len(sys.stdin.read())
row = {"time": 0, "position": [0, alive, 0], "following_error": [0, 0.001, 0]}
print(json.dumps({"rows": [row], "argv": sys.argv}))
print(json.dumps({"released": True, "from": 0.1, "to": 0.1213, "by": 0.05}))
"""
TALKS = """
print("joint  follows"); print(); print("    2     100%")
"""
JOG = {"--joint": "2", "--by": "0.05"}


def started(folder: Path, monkeypatch: pytest.MonkeyPatch, program: str) -> RecordingProcess:
    monkeypatch.setattr("ident.workbench.recording_process.daq_command", lambda: [sys.executable, "-c", program])
    process = RecordingProcess(folder, Changes())
    process.mark_seen()
    return process


def finished(process: RecordingProcess) -> RunStatus:
    assert process.run
    deadline = time.monotonic() + 60
    while process.run.exit_code is None:
        assert time.monotonic() < deadline, "timeout"
        time.sleep(0.02)
    return process.run


def test_a_jog_gets_keep_alives_until_it_is_released(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    process = started(tmp_path, monkeypatch, HELD)
    process.commission("jog", JOG)
    for _ in range(3):
        process.keep_alive()
    assert process.running, "the program waits for the end of its input"
    with pytest.raises(BadInput, match="in progress"):
        process.commission("jog", JOG)
    process.release()
    run = finished(process)
    assert run.status["argv"] == ["-c", "jog", "--joint", "2", "--by", "0.05", "--hold", "--status"]
    assert run.latest("position") == 3
    assert _state(run) == (
        "daq jog: released after +0.0213 of +0.05 rad; drives off. · at +3.0000 rad, following error +1.00 mrad"
    )
    process.keep_alive()
    process.release()


def test_a_jog_that_ended_by_itself_needs_no_keep_alives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    process = started(tmp_path, monkeypatch, "")
    process.commission("jog", JOG)
    assert finished(process).exit_code == 0
    process.keep_alive()
    process.release()


def test_the_table_of_an_axis_check_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    process = started(tmp_path, monkeypatch, TALKS)
    process.commission("axis-check", {"--joint": "2"})
    process.keep_alive()
    run = finished(process)
    assert list(run.messages) == ["joint  follows", "    2     100%"]
    assert _state(run) == "daq axis-check: done."


def test_joints_that_do_not_exist_are_refused(tmp_path: Path) -> None:
    process = RecordingProcess(tmp_path, Changes())
    with pytest.raises(BadInput, match="1 to 3 expected, 4 found"):
        process.commission("jog", {**JOG, "--joint": "4"})
    with pytest.raises(BadInput, match="1 to 3 expected, 0 found"):
        process.rig_and_joint({"--joint": "0"})
    assert process.run is None


def test_a_failure_is_the_reason() -> None:
    run = RunStatus(("daq", "jog"), None, exit_code=1)
    run.messages.append("error: joint 2: following error")
    assert _state(run) == "daq jog: ended early, error: joint 2: following error. The simulated drives were disabled."


@pytest.mark.slow
def test_a_held_button_moves_the_joint(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    """Held with the keyboard to the end, then with the pointer until it is released in mid motion."""
    workbench = serve(tmp_path)
    browser.open(workbench.address)
    browser.click("tab-record")
    browser.at("commission").get_by_text("Commission one joint").click()
    hold, state = browser.at("jog-hold"), browser.at("jog-state")
    hold.wait_for()
    hold.focus()
    browser.page.keyboard.down("Space")
    # A busy machine may delay the keep-alives, which releases the joint.
    state.filter(has_text=re.compile(r"(done|released) after [+-]")).wait_for()
    browser.page.keyboard.up("Space")
    browser.at("jog-by").fill("0.5")
    hold.hover()
    browser.page.mouse.down()
    state.filter(has_text=re.compile(r"stream|stop|disable|of \+0\.5")).wait_for()
    browser.page.mouse.up()
    state.filter(has_text=re.compile(r"released after .* of \+0\.5 rad")).wait_for()
    browser.check_accessibility()
    browser.screenshot("commissioning")
