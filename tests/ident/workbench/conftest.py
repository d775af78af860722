"""Fixtures: a running workbench server and a Chromium tab."""

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests import chromium
from tests.conftest import launcher

ARTEFACTS = Path("runs") / "workbench-screenshots"

HIDDEN = """
voltage_noise = 0.01

[[effects]]
name = "stribeck"
joints = [2]
size = 0.03
"""


@dataclass
class RunningWorkbench:
    """A running workbench."""

    process: "subprocess.Popen[str]"
    address: str
    folder: Path


Serve = Callable[..., RunningWorkbench]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Return a function that starts `ident workbench` on a folder or files; it is ended with Ctrl-C."""
    with ExitStack() as stack:

        def start(folder: Path, *paths: str) -> RunningWorkbench:
            command = [*launcher("ident"), "workbench", *(paths or ["."]), "--no-browser"]
            process = subprocess.Popen(
                command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
            stack.callback(_end, process)
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("workbench: http://127.0.0.1:"), line
            return RunningWorkbench(process, line.split()[1], folder)

        yield start


def _end(process: "subprocess.Popen[str]") -> None:
    if process.poll() is not None:  # the test has ended it
        process.communicate()
        return
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=120)
    assert process.returncode == 0, out
    assert "Traceback" not in out, out


@pytest.fixture(scope="session")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings of a simulated robot with a hidden Stribeck effect in joint 2."""
    folder = tmp_path_factory.mktemp("hidden")
    (folder / "sim.toml").write_text(HIDDEN)
    for motion in ("fig5a", "fig5b"):
        command = ["record", "--traj", motion, "--sim", "sim.toml", "--out", f"{motion}.mcap"]
        subprocess.run([*launcher("daq"), *command], cwd=folder, check=True, capture_output=True, timeout=900)
    return folder


class Browser:
    """One browser tab with helpers for the tests."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", self._on_error)
        page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)

    def _on_error(self, error: Any) -> None:
        # NiceGUI lets Plotly resize a plot even if its tab has just been left.
        if "Resize must be passed a displayed plot" not in str(error):
            self.errors.append(str(error))

    def open(self, address: str) -> None:
        self.page.goto(address)
        self.page.locator('[data-test="tab-data"]').wait_for()

    def at(self, name: str) -> Any:
        """Return the element with this test identifier."""
        return self.page.locator(f'[data-test="{name}"]')

    def click(self, name: str) -> None:
        self.at(name).click()

    def text(self, name: str) -> str:
        return str(self.at(name).inner_text())

    def screenshot(self, name: str) -> None:
        """Save a screenshot."""
        self.page.evaluate("window.scrollTo(0, 0)")  # the last click may have scrolled the page
        time.sleep(1.0)  # wait for the plots
        ARTEFACTS.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=ARTEFACTS / f"{name}.png")


@pytest.fixture
def browser() -> Iterator[Browser]:
    with chromium.tab() as page:
        tab = Browser(page)
        yield tab
    assert not tab.errors
