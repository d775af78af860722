"""Fixtures: running workbench servers and a Chromium tab."""

import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests import axe, chromium
from tests.conftest import launcher
from tests.patience import patient

ARTEFACTS = Path("runs") / "workbench-screenshots"

HIDDEN = """
voltage_noise = 0.01

[[effects]]
name = "stribeck"
joints = [2]
size = 0.03
"""
_ENABLED = """name => {
    const control = document.querySelector(`[data-test='${name}']`);
    return control && !control.closest("[disabled], .disabled");
}"""
"""Whether a control is there and can be used; it may be drawn anew just then."""
_LISTEN = """() => {
    window.pressed = null;
    const note = event => { window.pressed = event.target.closest("[data-test]")?.dataset.test; };
    document.addEventListener("click", note, {capture: true, once: true});
}"""
"""Note which control is clicked next, with a key or a mouse."""
_COLOURED = """() => document.getAnimations().every(
    each => each.playState !== "running" || each.effect.getComputedTiming().iterations === Infinity)"""
"""Whether no colour changes any more: axe-core takes one in between for the contrast."""
_FITS = """() => document.documentElement.scrollWidth <= document.documentElement.clientWidth
    && [...document.querySelectorAll(".js-plotly-plot, .js-plotly-plot .main-svg, .scroll-x, table, pre")]
        .every(item => (item.parentElement.closest(".scroll-x, .nicegui-code") ?? item)
            .getBoundingClientRect().right <= innerWidth)"""
"""Whether nothing is wider than the window, as soon as all plots are drawn."""
_MAX_PRESSES = 10
"""Presses after which a control counts as one that does not react."""
_MAX_TABS = 200
"""Presses of Tab after which a control counts as out of reach."""


@dataclass
class RunningWorkbench:
    """A running workbench."""

    process: "subprocess.Popen[str]"
    address: str
    folder: Path


Serve = Callable[..., RunningWorkbench]
NewFolder = Callable[[], Path]


@contextmanager
def servers() -> Iterator[Serve]:
    """Give a function that starts `ident workbench` on a folder or files; it is ended with Ctrl-C."""
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


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Return a function that starts a workbench for one test."""
    with servers() as start:
        yield start


def _end(process: "subprocess.Popen[str]") -> None:
    if process.poll() is not None:  # the test has ended it
        process.communicate()
        return
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=patient(120))
    assert process.returncode == 0, out
    assert "site-packages" not in out, out  # neither a traceback nor the warning of a library


@pytest.fixture(scope="session")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> NewFolder:
    """Return a function that gives a new folder with two recordings: a Stribeck effect is hidden in joint 2.

    A workbench that opens a folder of two recordings chooses both, so none may work in the folder of another.
    """
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "sim.toml").write_text(HIDDEN)
    for motion in ("fig5a", "fig5b"):
        options = ["--cycles", "2", "--rate", "250", "--sim", "sim.toml", "--out", f"{motion}.mcap"]
        command = [*launcher("daq"), "record", "--traj", motion, *options]
        subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=patient(900))
    return lambda: shutil.copytree(folder, tmp_path_factory.mktemp("hidden"), dirs_exist_ok=True)


@pytest.fixture(scope="module")
def workbench(hidden: NewFolder) -> Iterator[RunningWorkbench]:
    """Return a workbench on the two recordings for all tests of a module."""
    with servers() as start:
        yield start(hidden())


@pytest.fixture
def own_workbench(hidden: NewFolder, serve: Serve) -> RunningWorkbench:
    """A workbench that nobody has used: whether the page asks before a fit depends on what was done before."""
    return serve(hidden())


class Browser:
    """One browser tab with helpers for the tests."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.errors: list[str] = []
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda message: self.errors.append(message.text) if message.type == "error" else None)

    def open(self, address: str, width: int = 1280, height: int = 800) -> None:
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.goto(address)
        self.page.locator('[data-test="tab-data"]').wait_for()

    def at(self, name: str) -> Any:
        """Return the element with this test identifier."""
        return self.page.locator(f'[data-test="{name}"]')

    def rms(self, kind: str, step: int, joint: int) -> float:
        """Return an error from the table of the list of steps."""
        return float(self.text(f"{kind}-{step}-{joint}"))

    def click(self, *names: str) -> None:
        """Click one control after the other, each as soon as it can be; again where it has moved from the pointer."""
        for name in names:
            if not any(self._click(name) for _ in range(_MAX_PRESSES)):
                raise AssertionError(f"{name} never takes the click")

    def _click(self, name: str) -> bool:
        """Click a control, and return whether the click came to it."""
        self.page.evaluate(_LISTEN)
        self.at(name).click()
        return bool(self.page.evaluate("window.pressed") == name)

    def click_for(self, control: Any, shown: Any) -> None:
        """Click `control` until `shown` is there; again, since a control that moves or is drawn anew loses clicks."""
        from playwright.sync_api import TimeoutError as NotYet

        for _ in range(_MAX_PRESSES):
            control.click()
            with suppress(NotYet):
                shown.wait_for(timeout=1e3 * patient(30))
                return
        raise AssertionError(f"{control} never takes the click")

    def press(self, *names: str, key: str = "Enter") -> None:
        """Move to one control after the other with Tab alone, among tabs with an arrow, and press a key there.

        It is pressed again if it was not there any more when the key came, because a busy machine has drawn it anew
        or loaded the page again; and a tab if it is not shown, which a page that is drawing another may have missed.
        """
        for name in names:
            if not any(self._press(name, key) for _ in range(_MAX_PRESSES)):
                raise AssertionError(f"{name} never takes the key")

    def _press(self, name: str, key: str) -> bool:
        """Press a key on a control, and return whether the press came to it."""
        self._move_to(name)
        self.page.evaluate(_LISTEN)
        self.page.keyboard.press(key)
        if name.startswith("tab-"):
            return self._is_shown(name)
        return key != "Enter" or self.page.evaluate("window.pressed") == name

    def _is_shown(self, tab: str) -> bool:
        """Whether `tab` is shown, at once or within a while in which even a busy machine draws it."""
        for _ in range(60):
            if self.at(tab).get_attribute("aria-selected") == "true":
                return True
            self.page.wait_for_timeout(1e3)
        return False

    def _move_to(self, name: str) -> None:
        self.at(name).wait_for()
        self.page.wait_for_function(_ENABLED, arg=name)
        next_key = "Tab"
        for _ in range(_MAX_TABS):
            self.page.keyboard.press(next_key)
            if name.startswith("tab-") and self._focused().startswith("tab-"):
                next_key = "Home" if next_key == "Tab" else "ArrowRight"
            if self._focused() == name:
                return
        raise AssertionError(f"{name} cannot be reached with Tab")

    def _focused(self) -> str:
        return self.page.evaluate("document.activeElement?.closest('[data-test]')?.dataset.test") or ""

    def text(self, name: str) -> str:
        return str(self.at(name).inner_text())

    def wait_for_text(self, name: str, text: "str | re.Pattern[str]") -> None:
        """Wait until the element with this test identifier holds `text`."""
        self.at(name).filter(has_text=text).first.wait_for()

    def check(self, name: str = "") -> None:
        """Assert that axe-core finds nothing serious, and that nothing is too wide; save a screenshot as `name`."""
        self.page.wait_for_timeout(500)  # what fades in has begun to, and ends late on a busy machine
        # A notice fades out, too, at any time.
        fading = '[class*="-enter-active"], [class*="-leave-active"], .q-notification'
        self.page.wait_for_function("fading => !document.querySelector(fading)", arg=fading)
        self.page.wait_for_function(_COLOURED)
        assert not axe.findings(self.page)
        self.page.wait_for_function(_FITS)
        if name:
            self.screenshot(name)

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
