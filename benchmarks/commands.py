"""Measure time and peak memory of the commands `ident fit` and `ident diagnose` for several lengths of recordings.

The recordings contain a hidden effect. `--against CHECKOUT` runs the commands of this and of another checkout in turn
on the same recordings, the longest ones excepted, and prints the ratios of their times and of their peak memory.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.long_recording import make
from benchmarks.programs import ratio, record_demo

SECONDS = (20.0, 600.0, 3600.0)
"""Lengths of the recordings [s]."""
LONG, FAST = 750.0, 800.0
"""Length [s] and rate [Hz] of a long and fast recording: as many samples as in ten minutes at 1 kHz,
which would take more of the simulated bus than is allowed."""
PAIRS = 7
"""Runs of each checkout that are compared."""
HERE = Path(__file__).parents[1]


def main() -> None:
    """Measure this checkout, or compare it with another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, metavar="CHECKOUT", help="compare with this checkout")
    against: Path | None = parser.parse_args().against
    if against:  # its files can be read here, not the other way round
        os.environ["PYTHONPATH"] = str(against.resolve())
    with tempfile.TemporaryDirectory() as folder:
        for title, arguments in commands(Path(folder), () if against else SECONDS):
            if against:
                _compare(title, arguments, against.resolve())
            else:
                _measure(title, arguments)


def commands(folder: Path, lengths: Sequence[float]) -> Iterator[tuple[str, list[object]]]:
    """Yield the arguments of `ident` with their titles; the recordings in `folder` are made as they are needed.

    lengths: of further recordings [s].
    """
    yield "ident --help", ["--help"]
    demo, held_out = record_demo(folder, "fig5a", "fig5b")
    fit = ["-o", folder / "model.json", "--force"]
    validate, page = ["--validate", held_out], ["--report", folder / "page.html", "--force"]
    for arguments in (["fit", demo, *fit], ["diagnose", demo, *validate, *page]):
        run(arguments)  # compiles
    yield "ident fit", ["fit", demo, *fit]
    if lengths:  # an older checkout draws them always
        yield "the same with its pictures", ["fit", demo, *fit, "--pictures", folder / "pictures"]
    yield "ident diagnose", ["diagnose", demo, "--json"]
    yield "ident diagnose, another recording held out", ["diagnose", demo, *validate, "--json"]
    yield "the same with its page", ["diagnose", demo, *validate, *page]
    (fast,) = record_demo(folder / "fast", "fig5a", rate=FAST)
    long = folder / "long.mcap"
    make(fast, long, LONG)
    yield f"ident diagnose, {LONG:.0f} s at {FAST:.0f} Hz", ["diagnose", long, "--json"]
    for seconds in lengths:
        long.unlink()
        make(demo, long, seconds)
        title = f"{seconds:.0f} s at 500 Hz, {long.stat().st_size / 1e6:.0f} MB"
        yield f"ident fit, {title}", ["fit", long, *fit]
        yield f"ident diagnose, {title}", ["diagnose", long, *page]


def _measure(title: str, arguments: Sequence[object]) -> None:
    seconds, memory = run(arguments)
    print(f"command: {title}: {seconds:.2f} s, at most {memory:.0f} MB", flush=True)


def _compare(title: str, arguments: Sequence[object], other: Path) -> None:
    """Print the ratios of the times and peak memories of this checkout and of the `other`, pair by pair."""
    pairs = [(run(arguments), run(arguments, other)) for _ in range(PAIRS + 1)][1:]
    for index, unit in enumerate(("s", "MB")):
        here, there = zip(*((one[index], two[index]) for one, two in pairs), strict=True)
        print(
            f"command: {title}: {statistics.median(here):.2f} {unit} here, {statistics.median(there):.2f} {unit} "
            f"there; ratio {ratio(here, there)}",
            flush=True,
        )


def run(arguments: Sequence[object], code: Path = HERE) -> tuple[float, float]:
    """Run `ident` of the checkout `code` to its end; return its duration [s] and peak memory [MB]."""
    command = [sys.executable, "-c", "from ident.cli import main; main()", *map(str, arguments)]
    start, environment = time.perf_counter(), os.environ | {"PYTHONPATH": str(code)}
    process = subprocess.Popen(
        command, cwd=code, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, usage.ru_maxrss * 1024e-6


if __name__ == "__main__":
    main()
