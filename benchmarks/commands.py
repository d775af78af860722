"""Whole commands, as a user waits for them: time and peak memory of `ident fit` and `ident diagnose` on recordings of
any length, in which an effect is hidden."""

import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.demo import program, record
from benchmarks.long_recording import make

SECONDS = (20.0, 600.0, 3600.0)
"""Of the recordings."""


def main() -> None:
    """Print time and memory; compilation, kept on disk after a first run, is not counted."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _print("ident --help", [program("ident"), "--help"])
        demo, other = record(folder, "fig5a", "fig5b")
        run(_fit(demo, folder))
        run(_diagnose(folder, demo))
        _print("ident fit, demo recording", _fit(demo, folder))
        _print("ident diagnose, demo recording", _diagnose(folder, demo))
        _print(
            "ident diagnose, demo recording and another held out", _diagnose(folder, demo, "--validate", str(other))
        )
        for seconds in SECONDS:
            path = folder / "long.mcap"
            path.unlink(missing_ok=True)
            make(demo, path, seconds)
            what = f"{seconds:.0f} s at 500 Hz, {path.stat().st_size / 1e6:.0f} MB"
            _print(f"ident fit, {what}", _fit(path, folder))
            _print(f"ident diagnose, {what}", _diagnose(folder, path))


def _fit(path: Path, folder: Path) -> list[str]:
    out = ["-o", str(folder / "model.json"), "--plots", str(folder / "plots"), "--force"]
    return [program("ident"), "fit", str(path), *out]


def _diagnose(folder: Path, path: Path, *more: str) -> list[str]:
    return [program("ident"), "diagnose", str(path), *more, "--plots", str(folder / "diagnosed"), "--force"]


def _print(what: str, command: Sequence[str]) -> None:
    seconds, memory = run(command)
    print(f"command: {what}: {seconds:.2f} s, at most {memory / 1e6:.0f} MB", flush=True)


def run(command: Sequence[str]) -> tuple[float, float]:
    """Run `command` to its end: seconds, and the most memory it held at any time [bytes]."""
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.perf_counter() - start, used.ru_maxrss * 1024.0


if __name__ == "__main__":
    main()
