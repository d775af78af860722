"""Measure time and peak memory of the commands `ident fit` and `ident diagnose` for several lengths of recordings.

The recordings contain a hidden effect. `--against CHECKOUT` runs the two commands of this and of another checkout in
turn on the same recordings, and prints the ratios of their times and of their peak memory.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.long_recording import make
from benchmarks.programs import program, ratio, record_demo

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
    if against:
        compare(against.resolve())
    else:
        measure()


def compare(other: Path) -> None:
    """Print the ratio of the times of this checkout and of the `other`, pair by pair."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        demo, held_out = record_demo(folder, "fig5a", "fig5b")
        long = _long_and_fast(folder)
        validate, page = ["--validate", str(held_out)], ["--report", str(folder / "page.html"), "--force"]
        for title, arguments in (
            ("fit", ["fit", str(demo), "-o", str(folder / "model.json"), "--force"]),
            ("diagnose", ["diagnose", str(demo), "--json"]),
            ("diagnose, another recording held out", ["diagnose", str(demo), *validate, "--json"]),
            ("the same with its page", ["diagnose", str(demo), *validate, *page]),
            (f"diagnose, {LONG:.0f} s at {FAST:.0f} Hz", ["diagnose", str(long), "--json"]),
        ):
            pairs = [(_ident(HERE, arguments), _ident(other, arguments)) for _ in range(PAIRS + 1)][1:]
            here, there = zip(*pairs, strict=True)
            _print_ratio(f"ident {title}", "s", *([each[0] for each in side] for side in (here, there)))
            _print_ratio(
                f"ident {title}: memory", "MB", *([each[1] / 1e6 for each in side] for side in (here, there))
            )


def _ident(code: Path, arguments: Sequence[str]) -> tuple[float, float]:
    return run([sys.executable, "-c", "from ident.cli import main; main()", *arguments], code)


def _print_ratio(title: str, unit: str, here: Sequence[float], there: Sequence[float]) -> None:
    print(
        f"command: {title}: {statistics.median(here):.2f} {unit} here, {statistics.median(there):.2f} {unit} there; "
        f"ratio {ratio(here, there)}",
        flush=True,
    )


def measure() -> None:
    """Print time and memory. A first run fills the compilation cache and is not counted."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _measure("ident --help", [program("ident"), "--help"])
        demo, other = record_demo(folder, "fig5a", "fig5b")
        run(_fit_command(demo, folder))
        run(_diagnose_command(folder, demo))
        _measure("ident fit, demo recording", _fit_command(demo, folder))
        _measure("ident diagnose, demo recording", _diagnose_command(folder, demo))
        _measure(
            "ident diagnose, demo recording and another held out",
            _diagnose_command(folder, demo, "--validate", str(other)),
        )
        title = f"ident diagnose, {LONG:.0f} s at {FAST:.0f} Hz, as many samples as in 10 min at 1 kHz"
        _measure(title, _diagnose_command(folder, _long_and_fast(folder)))
        for seconds in SECONDS:
            path = folder / "long.mcap"
            path.unlink(missing_ok=True)
            make(demo, path, seconds)
            title = f"{seconds:.0f} s at 500 Hz, {path.stat().st_size / 1e6:.0f} MB"
            _measure(f"ident fit, {title}", _fit_command(path, folder))
            _measure(f"ident diagnose, {title}", _diagnose_command(folder, path))


def _long_and_fast(folder: Path) -> Path:
    """Recording of LONG seconds at FAST samples per second."""
    (fast,) = record_demo(folder / "fast", "fig5a", rate=FAST)
    path = folder / "long-and-fast.mcap"
    make(fast, path, LONG)
    return path


def _fit_command(path: Path, folder: Path) -> list[str]:
    out = ["-o", str(folder / "model.json"), "--pictures", str(folder / "pictures"), "--force"]
    return [program("ident"), "fit", str(path), *out]


def _diagnose_command(folder: Path, path: Path, *more: str) -> list[str]:
    return [program("ident"), "diagnose", str(path), *more, "--report", str(folder / "diagnosed.html"), "--force"]


def _measure(title: str, command: Sequence[str]) -> None:
    seconds, memory = run(command)
    print(f"command: {title}: {seconds:.2f} s, at most {memory / 1e6:.0f} MB", flush=True)


def run(command: Sequence[str], code: Path = HERE) -> tuple[float, float]:
    """Run `command` to its end on the packages of `code`; return its duration [s] and peak memory [bytes]."""
    start, environment = time.perf_counter(), os.environ | {"PYTHONPATH": str(code)}
    process = subprocess.Popen(
        command, cwd=code, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, usage.ru_maxrss * 1024.0


if __name__ == "__main__":
    main()
