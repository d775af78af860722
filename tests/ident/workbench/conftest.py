"""The workbench as a user has it: a server of its own, and Debian's browser in front of it."""

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
class Served:
    """A running workbench."""

    process: "subprocess.Popen[str]"
    address: str
    folder: Path


Serve = Callable[..., Served]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Start `ident workbench` on a folder or files; ended with Ctrl-C."""
    with ExitStack() as stack:

        def start(folder: Path, *places: str) -> Served:
            command = [*launcher("ident"), "workbench", *(places or ["."]), "--no-browser"]
            process = subprocess.Popen(
                command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
            stack.callback(_end, process)
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("workbench: http://127.0.0.1:"), line
            return Served(process, line.split()[1], folder)

        yield start


def _end(process: "subprocess.Popen[str]") -> None:
    if process.poll() is not None:  # the test has seen to it
        process.communicate()
        return
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=120)
    assert process.returncode == 0, out
    assert "Traceback" not in out, out


@pytest.fixture(scope="session")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings of a simulated robot with more friction near standstill in joint 2 than the model knows."""
    folder = tmp_path_factory.mktemp("hidden")
    (folder / "sim.toml").write_text(HIDDEN)
    for motion in ("fig5a", "fig5b"):
        command = ["record", "--traj", motion, "--sim", "sim.toml", "--out", f"{motion}.mcap"]
        subprocess.run([*launcher("daq"), *command], cwd=folder, check=True, capture_output=True, timeout=900)
    return folder


class Browser:
    """One tab, with what the tests do to it."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", self._failed)
        page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)

    def _failed(self, error: Any) -> None:
        # NiceGUI asks Plotly to fit a plot to its place also when its tab has just been left.
        if "Resize must be passed a displayed plot" not in str(error):
            self.errors.append(str(error))

    def open(self, address: str) -> None:
        self.page.goto(address)
        self.page.locator('[data-test="tab-data"]').wait_for(timeout=120_000)

    def at(self, name: str) -> Any:
        """The element that carries this name for tests."""
        return self.page.locator(f'[data-test="{name}"]')

    def click(self, name: str, patience: float = 120.0) -> None:
        self.at(name).click(timeout=1e3 * patience)

    def text(self, name: str, patience: float = 120.0) -> str:
        return str(self.at(name).inner_text(timeout=1e3 * patience))

    def shot(self, name: str) -> None:
        """Kept, to be looked at."""
        self.page.evaluate("window.scrollTo(0, 0)")  # the last click may have been far below
        time.sleep(1.0)  # plots settle
        ARTEFACTS.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=ARTEFACTS / f"{name}.png")


@pytest.fixture
def browser() -> Iterator[Browser]:
    with chromium.tab() as page:
        tab = Browser(page)
        yield tab
    assert not tab.errors
