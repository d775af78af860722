"""Measure time and peak memory of the commands `ident fit` and `ident diagnose` for several lengths of recordings.

The recordings contain a hidden effect.
"""

import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.demo import program, record
from benchmarks.long_recording import make

SECONDS = (20.0, 600.0, 3600.0)
"""Lengths of the recordings [s]."""


def main() -> None:
    """Print time and memory. A first run fills the compilation cache and is not counted."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _measure("ident --help", [program("ident"), "--help"])
        demo, other = record(folder, "fig5a", "fig5b")
        run(_fit_command(demo, folder))
        run(_diagnose_command(folder, demo))
        _measure("ident fit, demo recording", _fit_command(demo, folder))
        _measure("ident diagnose, demo recording", _diagnose_command(folder, demo))
        _measure(
            "ident diagnose, demo recording and another held out",
            _diagnose_command(folder, demo, "--validate", str(other)),
        )
        for seconds in SECONDS:
            path = folder / "long.mcap"
            path.unlink(missing_ok=True)
            make(demo, path, seconds)
            title = f"{seconds:.0f} s at 500 Hz, {path.stat().st_size / 1e6:.0f} MB"
            _measure(f"ident fit, {title}", _fit_command(path, folder))
            _measure(f"ident diagnose, {title}", _diagnose_command(folder, path))


def _fit_command(path: Path, folder: Path) -> list[str]:
    out = ["-o", str(folder / "model.json"), "--plots", str(folder / "plots"), "--force"]
    return [program("ident"), "fit", str(path), *out]


def _diagnose_command(folder: Path, path: Path, *more: str) -> list[str]:
    return [program("ident"), "diagnose", str(path), *more, "--report", str(folder / "diagnosed.html"), "--force"]


def _measure(title: str, command: Sequence[str]) -> None:
    seconds, memory = run(command)
    print(f"command: {title}: {seconds:.2f} s, at most {memory / 1e6:.0f} MB", flush=True)


def run(command: Sequence[str]) -> tuple[float, float]:
    """Run `command` to its end; return its duration [s] and peak memory [bytes]."""
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, usage.ru_maxrss * 1024.0


if __name__ == "__main__":
    main()
