"""`daq record --live` as a user has it, and a browser in front of it. In lockstep, so that a busy machine changes
nothing: a motion lasts about a fifth of its time.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.reader import read
from tests import chromium
from tests.conftest import Runner, launcher
from tests.patience import patient
from tests.running import DRIVES

EVIL = "<img src=x onerror=window.hacked=1>"
RIG = f'name = "{EVIL}"\nrate = 250.0\n[bus]\ninterface = "virtual"\nchannel = "live"\n' + DRIVES
Record = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Record]:
    """Start `daq record --live` on the simulated rig, without opening a browser."""
    monkeypatch.setenv("BROWSER", "false")
    (tmp_path / "rig.toml").write_text(RIG)
    with ExitStack() as stack:

        def start(*arguments: str) -> "subprocess.Popen[str]":
            command = ["record", "--traj", "fig5a", "--rig", "rig.toml", "--out", "a.mcap"]
            process = stack.enter_context(
                subprocess.Popen(
                    [*launcher("daq"), *command, "--live", *arguments],
                    cwd=tmp_path,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                    text=True,
                    start_new_session=True,  # as in a terminal of its own
                )
            )
            stack.callback(process.kill)
            return process

        yield start


def address(process: "subprocess.Popen[str]") -> str:
    assert process.stderr is not None
    line = process.stderr.readline()
    assert line.startswith("live view: http://127.0.0.1:"), line
    return line.split()[-1]


def wait_for(page: Any, state: str) -> str:
    """Wait until the state on the page begins with `state`; return it."""
    page.wait_for_function(f"document.getElementById('state').textContent.startsWith('{state}')")
    return str(page.inner_text("#state"))


@pytest.fixture
def page() -> Iterator[Any]:
    with chromium.tab() as tab:
        errors: list[str] = []
        tab.on("pageerror", lambda error: errors.append(str(error)))
        # If the server dies, the browser logs it on its console, so only policy violations count.
        tab.on("console", lambda said: errors.append(said.text) if "violates" in said.text else None)
        yield tab
        assert not errors


@pytest.mark.slow
def test_page_shows_the_run_to_its_end(record: Record, page: Any, tmp_path: Path) -> None:
    (tmp_path / "sim.toml").write_text('[[drives]]\n[drives.habits]\ntrouble = "long_tpdo"\n')
    process = record("--cycles", "25", "--sim", "sim.toml")
    page.goto(address(process))
    # The plotted values are compared with the file below. A busy browser may show none of the states on the way.
    page.wait_for_function("document.getElementById('position').data?.[0]?.x.length > 50")
    names = ["position", "error", "voltage", "lateness"]
    lines = page.evaluate(f"Object.fromEntries({names}.map((id) => [id, document.getElementById(id).data]))")
    assert wait_for(page, "done") == "done: a.mcap is whole"
    assert page.inner_text("#reports").count("9 bytes, 8 are mapped") == 3
    page.screenshot(path=_artefact("live"))
    assert process.wait(patient(120)) == 0
    recording = read(tmp_path / "a.mcap")
    for j in range(3):
        shown, commanded = lines["position"][2 * j : 2 * j + 2]
        rows = [round(250 * time) for time in shown["x"]]
        assert shown["y"] == [_known(item) for item in recording.position[rows, j]]
        assert commanded["y"] == pytest.approx([_known(item) for item in recording.command[rows, j]], abs=1e-8)
        assert lines["voltage"][j]["y"] == [_known(item) for item in recording.voltage[rows, j]]
        error = [
            _known(item) for item in 1e3 * (recording.command[np.array(rows) - 1] - recording.position[rows])[:, j]
        ]
        assert lines["error"][j]["y"] == pytest.approx(error, abs=1e-5)
    assert max(lines["lateness"][0]["y"]) <= 1e3 * recording.lateness.max() + 1e-9
    assert page.inner_text("h1").startswith(f"fig5a on {EVIL}"), "names are text"
    assert page.evaluate("window.hacked") is None
    assert page.is_visible("text=SIMULATED RIG")


def _known(value: float) -> float | None:
    return None if value != value else float(value)


def _artefact(name: str) -> Path:
    folder = Path("runs") / "live-screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name}.png"


SLOW_BROWSER = """
import http.cookiejar, pathlib, re, sys, time, urllib.parse, urllib.request
link = pathlib.Path(urllib.request.url2pathname(urllib.parse.urlparse(sys.argv[1]).path)).read_text()
time.sleep(15)
address = re.search('url=([^ ]+)">', link)[1]
browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()))
browser.open(address).read()
events = browser.open(urllib.parse.urljoin(address, "/events"), timeout=60).read()
pathlib.Path("shown.txt").write_bytes(events)
"""


@pytest.mark.slow
def test_a_run_of_ten_seconds_is_shown_by_a_browser_that_opens_after_its_end(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "browser.py").write_text(SLOW_BROWSER)
    monkeypatch.setenv("BROWSER", f"{sys.executable} browser.py %s")
    process = record("--cycles", "2")
    _, said = process.communicate(timeout=patient(120))
    assert process.returncode == 0, said
    assert "waiting until the live view has shown the end; Ctrl-C ends this" in said
    lines = [
        json.loads(line.removeprefix("data: ")) for line in (tmp_path / "shown.txt").read_text().split("\n\n")[:-1]
    ]
    times = [row["time"] for line in lines for row in line.get("rows", ())]
    recording = read(tmp_path / "a.mcap")
    assert times[0] < 1.0
    assert times[-1] == pytest.approx(recording.time[-1], abs=0.2)
    assert lines[-1] == {"ended": None}


@pytest.mark.slow
def test_ctrl_c_stops_orderly_and_the_page_shows_it(record: Record, page: Any, tmp_path: Path) -> None:
    process = record("--cycles", "150")
    page.goto(address(process))
    wait_for(page, "stream")
    os.killpg(process.pid, signal.SIGINT)
    assert "SIGINT" in wait_for(page, "ended early")
    assert process.wait(patient(120)) == 1
    recording = read(tmp_path / "a.mcap")
    assert "SIGINT" in str(recording.run.reason)
    assert "quick stop" not in str(recording.run.reason)


@pytest.mark.slow
def test_page_shows_that_the_recorder_was_killed(record: Record, page: Any) -> None:
    process = record("--cycles", "150")
    page.goto(address(process))
    wait_for(page, "stream")
    process.kill()
    assert "LOOK AT THE DRIVES" in wait_for(page, "daq record was killed")


@pytest.mark.slow
def test_recording_is_the_same_with_and_without_viewers(
    daq: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BROWSER", "false")
    for more in ([], ["--live"]):
        done = daq("record", "--traj", "fig5a", "--cycles", 1, "--rate", 250, "--out", f"{len(more)}.mcap", *more)
        assert done.code == 0, done.err
    assert (tmp_path / "0.mcap").read_bytes() == (tmp_path / "1.mcap").read_bytes()
