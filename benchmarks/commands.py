"""Measure time and peak memory of the commands `ident fit` and `ident diagnose` for several lengths of recordings.

The recordings contain a hidden effect.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.long_recording import make
from benchmarks.programs import record_demo

SECONDS = (20.0, 600.0, 3600.0)
"""Lengths of the recordings [s]."""
LONG, FAST = 750.0, 800.0
"""Length [s] and rate [Hz] of a long and fast recording: as many samples as in ten minutes at 1 kHz,
which would take more of the simulated bus than is allowed."""


def main() -> None:
    """Measure each command."""
    with tempfile.TemporaryDirectory() as folder:
        for title, arguments in commands(Path(folder)):
            seconds, memory = run(arguments)
            print(f"command: {title}: {seconds:.2f} s, at most {memory:.0f} MB", flush=True)


def commands(folder: Path) -> Iterator[tuple[str, list[object]]]:
    """Yield the arguments of `ident` with their titles; the recordings in `folder` are made as they are needed."""
    yield "ident --help", ["--help"]
    demo, held_out = record_demo(folder, "fig5a", "fig5b")
    fit = ["-o", folder / "model.json", "--force"]
    validate, page = ["--validate", held_out], ["--report", folder / "page.html", "--force"]
    for arguments in (["fit", demo, *fit], ["diagnose", demo, *validate, *page]):
        run(arguments)  # compiles
    yield "ident fit", ["fit", demo, *fit]
    yield "the same with its pictures", ["fit", demo, *fit, "--pictures", folder / "pictures"]
    yield "ident diagnose", ["diagnose", demo, "--json"]
    yield "ident diagnose, another recording held out", ["diagnose", demo, *validate, "--json"]
    yield "the same with its page", ["diagnose", demo, *validate, *page]
    (fast,) = record_demo(folder / "fast", "fig5a", rate=FAST)
    long = folder / "long.mcap"
    make(fast, long, LONG)
    yield f"ident diagnose, {LONG:.0f} s at {FAST:.0f} Hz", ["diagnose", long, "--json"]
    for seconds in SECONDS:
        long.unlink()
        make(demo, long, seconds)
        title = f"{seconds:.0f} s at 500 Hz, {long.stat().st_size / 1e6:.0f} MB"
        yield f"ident fit, {title}", ["fit", long, *fit]
        yield f"ident diagnose, {title}", ["diagnose", long, *page]


def run(arguments: Sequence[object]) -> tuple[float, float]:
    """Run `ident` to its end; return its duration [s] and peak memory [MB]."""
    command = [sys.executable, "-c", "from ident.cli import main; main()", *map(str, arguments)]
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, usage.ru_maxrss * 1024e-6


if __name__ == "__main__":
    main()
