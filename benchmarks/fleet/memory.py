"""Memory of a worker that analyses a long recording.

`python -m benchmarks.fleet.memory RECORDING --seconds 7200` repeats the motion of RECORDING for so long, analyses it
in one local Dask worker, and prints what that worker needed at most.
"""

import resource
import tempfile
from pathlib import Path

import click

from benchmarks import long_recording
from ident.fleet import engines
from ident.fleet.engines import EngineOptions
from ident.fleet.engines.dask import MEMORY
from ident.fleet.recording_rows import examine
from ident.fleet.settings import FleetSettings
from ident.fleet.walk import RecordingFile, walk
from recordings.errors import RunFailed

_MIB = 1024.0


def analysed(file: RecordingFile) -> tuple[str, float]:
    """Analyse a recording; return why it failed, or an empty text, and the peak memory of this worker [MiB]."""
    rows = examine(file, FleetSettings())
    return rows[0].get("reason", ""), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MIB


@click.command()
@click.argument("recording", type=click.Path(path_type=Path, exists=True, dir_okay=False))
@click.option("--seconds", default=7200.0, show_default=True, type=click.FloatRange(1))
def main(recording: Path, seconds: float) -> None:
    """Print the size of a recording of so many SECONDS and the peak memory of the worker that analyses it."""
    with tempfile.TemporaryDirectory() as folder:
        long_recording.make(recording, Path(folder) / "long.mcap", seconds)
        ((file, result),) = engines.load("dask").run(analysed, list(walk([Path(folder)])), EngineOptions(1))
    reason, peak = result or (f"{MEMORY} are not enough", 0.0)
    if reason:
        raise RunFailed(f"{recording}, repeated for {seconds:g} s: {reason}")
    print(f"{seconds:g} s, {file.size / 2**20:.0f} MiB: {peak:.0f} MiB in a worker with {MEMORY}")


if __name__ == "__main__":
    main()
