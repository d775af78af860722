"""Measure how long the workbench takes to show and fit one hour at 500 Hz in a real browser, and its memory."""

import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks import long_recording
from benchmarks.programs import program, record

HOUR = 3600.0
ZOOMS = 5
_PLOT = ".js-plotly-plot"
_WATCH = (
    f"() => document.querySelector('{_PLOT}').on('plotly_afterplot', () => {{ window.drawn = performance.now() }})"
)


def main() -> None:
    """Print the times of first view, whole view, zoom and fits, and the memory."""
    browser = shutil.which("chromium")
    if browser is None:
        print("workbench: needs Debian's chromium")
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = record(folder / "made.mcap", "fig5a", "--cycles", 2)
        long_recording.make(source, folder / "hour.mcap", HOUR)
        source.unlink()
        server = subprocess.Popen(
            [program("ident"), "workbench", str(folder), "--no-browser"], stdout=subprocess.PIPE, text=True
        )
        try:
            assert server.stdout is not None
            _measure(browser, server.stdout.readline().split()[1], server.pid)
        finally:
            server.terminate()
            server.wait(timeout=30)


def _measure(browser: str, address: str, server: int) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = launched.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.locator('[data-test="train-0"]').wait_for(timeout=60_000)
        time.sleep(5)  # a person reads the page before the first click
        start = time.perf_counter()
        page.locator('[data-test="train-0"]').click()
        page.locator(f"{_PLOT} .scatterlayer").first.wait_for(timeout=120_000)
        print(f"workbench, one hour at 500 Hz: first view {time.perf_counter() - start:.1f} s")
        page.get_by_text("the rest is being read").wait_for(state="detached", timeout=300_000)
        print(f"all of it {time.perf_counter() - start:.1f} s")
        page.evaluate(_WATCH)
        print(f"zoom: {', '.join(f'{_zoom(page):.0f} ms' for _ in range(ZOOMS))}")
        _memory(server, "shown")
        _fit(page)
        _memory(server, "fitted")
        launched.close()


def _fit(page: Any) -> None:
    """Time the base model, its candidates, and its residuals."""
    start = time.perf_counter()
    page.locator('[data-test="tab-missing"]').click()
    page.locator('[data-test="fit"]').click()
    page.locator('[data-test="step-0"]').wait_for(timeout=300_000)
    print(f"base model {time.perf_counter() - start:.1f} s")
    page.locator('[data-test^="card-"]').first.wait_for(timeout=300_000)
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
    drawn: float = page.evaluate("window.drawn")
    return drawn - released


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
