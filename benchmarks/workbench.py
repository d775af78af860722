"""Measure how long the workbench takes to show and fit long recordings in a real browser, and its memory."""

import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks import long_recording
from benchmarks.programs import DRIVES, program, record

HOUR = 3600.0
TEN_MINUTES = 600.0
_RIG = f"""name = "bench"
[bus]
interface = "virtual"
max_load = 0.9
{DRIVES}"""
"""Rows at 1 kHz fill more of the bus than is the rule."""
ZOOMS = 5
_PLOT = ".js-plotly-plot"
_WATCH = (
    f"() => document.querySelector('{_PLOT}').on('plotly_afterplot', () => {{ window.drawn = performance.now() }})"
)


def main() -> None:
    """Print the times of first view, whole view, zoom, selections and fits, and the memory."""
    browser = shutil.which("chromium")
    if browser is None:
        print("workbench: needs Debian's chromium")
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = record(folder / "made.mcap", "fig5a", "--cycles", 2)
        long_recording.make(source, folder / "hour.mcap", HOUR)
        source.unlink()
        _measure(browser, folder, "one hour at 500 Hz")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "rig.toml").write_text(_RIG)
        for motion in ("fig5a", "fig5b"):
            options = ("--cycles", 2, "--rate", 1000, "--rig", folder / "rig.toml")
            source = record(folder / f"short-{motion}.mcap", motion, *options)  # of more than two, none is chosen
            long_recording.make(source, folder / f"{motion}.mcap", TEN_MINUTES)
        _measure(browser, folder, "two recordings of ten minutes at 1 kHz", pair=True)


def _measure(browser: str, folder: Path, what: str, pair: bool = False) -> None:
    from playwright.sync_api import sync_playwright

    with _served(folder) as (address, server), sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = launched.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.locator('[data-test="train-0"]').wait_for(timeout=60_000)
        time.sleep(5)  # a person reads the page before the first click
        start = time.perf_counter()
        page.locator('[data-test="train-0"]').click()
        page.locator(f"{_PLOT} .scatterlayer").first.wait_for(timeout=120_000)
        print(f"workbench, {what}: first view {time.perf_counter() - start:.1f} s")
        page.get_by_text("the rest is being read").wait_for(state="detached", timeout=300_000)
        print(f"all of it {time.perf_counter() - start:.1f} s")
        page.evaluate(_WATCH)
        print(f"zoom: {', '.join(f'{_zoom(page):.0f} ms' for _ in range(ZOOMS))}")
        _memory(server, "shown")
        if pair:
            page.locator('[data-test="validate-1"]').click()
        _fit(page)
        if pair:
            _select(page)
        _memory(server, "fitted")
        launched.close()


@contextmanager
def _served(folder: Path) -> Iterator[tuple[str, int]]:
    command = [program("ident"), "workbench", str(folder), "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        yield server.stdout.readline().split()[1], server.pid
    finally:
        server.terminate()
        server.wait(timeout=30)


def _select(page: Any) -> None:
    """Time until another joint and another signal are drawn."""
    page.locator('[data-test="tab-model"]').click()
    page.locator(f"{_PLOT} .scatterlayer").first.wait_for(timeout=120_000)
    time.sleep(2)
    page.evaluate(_WATCH)
    for joint in (2, 3, 1):
        print(f"joint {joint}: {_until_drawn(page, page.get_by_role('button', name=f'joint {joint}')):.0f} ms")
    page.locator('[data-test="signals"]').click()
    for signal in ("velocity", "position"):
        option = page.get_by_role("option", name=signal)
        print(f"{signal}: {_until_drawn(page, option):.0f} ms")


def _until_drawn(page: Any, control: Any) -> float:
    """Time from a click on `control` until the plot has been drawn for the last time [ms]."""
    control.wait_for()
    clicked: float = page.evaluate("window.drawn = performance.now()")
    control.click()
    time.sleep(4)
    return page.evaluate("window.drawn") - clicked


def _fit(page: Any) -> None:
    """Time the base model, its candidates, and its residuals."""
    start = time.perf_counter()
    page.locator('[data-test="tab-missing"]').click()
    page.locator('[data-test="fit"]').click()
    page.locator('[data-test="step-0"]').wait_for(timeout=300_000)
    print(f"base model {time.perf_counter() - start:.1f} s")
    page.locator('[data-test^="card-"]').first.wait_for(state="attached", timeout=300_000)
    print(f"candidates {time.perf_counter() - start:.1f} s")
    page.locator('[data-test="tab-residuals"]').click()
    page.locator('[data-test="residuals-0"]').wait_for(timeout=600_000)
    print(f"where it fails {time.perf_counter() - start:.1f} s")


def _memory(server: int, done: str) -> None:
    """Print the sum of the peak memories of all processes."""
    workers = sum(map(_peak, _children(server)))
    page = _peak(server)
    print(f"memory at most, {done}: {page + workers:.0f} MB, page {page:.0f}, worker processes {workers:.0f}")


def _zoom(page: Any) -> float:
    """Time from the release of the mouse button until the detail is drawn [ms]."""
    page.mouse.move(500, 480)
    page.mouse.down()
    page.mouse.move(700, 485, steps=5)
    released: float = page.evaluate("performance.now()")
    page.mouse.up()
    time.sleep(1.5)
    return page.evaluate("window.drawn") - released


def _children(process: int) -> list[int]:
    identifiers = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(identifier) for identifier in identifiers]


def _peak(process: int) -> float:
    """Peak memory of a `process` [MB]."""
    status = Path(f"/proc/{process}/status").read_text()
    kilobytes = next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]
    return int(kilobytes) / 1e3


if __name__ == "__main__":
    main()
