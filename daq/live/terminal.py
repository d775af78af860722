"""Terminal output of a run: a progress bar with the key figures, and a summary at the end."""

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar
from rich.table import Table

from daq.cycle.background import BackgroundThread
from daq.cycle.progress import CycleProgress
from daq.cycle.session import Result
from recordings.recording import lateness_quantiles

_INTERVAL = 0.25
"""Time between two updates [s]."""


class ProgressBar(BackgroundThread):
    """Progress bar of a run, on stderr if that is a terminal. The cycle never waits for the screen."""

    def __init__(self, progress: CycleProgress) -> None:
        super().__init__("display")
        self._progress = progress

    def _run_thread(self) -> None:
        if not sys.stderr.isatty():
            return
        columns = (TextColumn("{task.description:>8}"), BarColumn(), TextColumn("{task.fields[figures]}"))
        with Bar(*columns, TimeElapsedColumn(), console=Console(stderr=True), auto_refresh=False) as bar:
            task = bar.add_task("start", figures="")
            before = 0
            while not self._finished.wait(_INTERVAL):
                progress = self._progress
                rate, before = (progress.cycles - before) / _INTERVAL, progress.cycles
                bar.update(
                    task,
                    description=progress.phase,
                    completed=progress.done,
                    total=progress.total,
                    figures=_figures(progress, rate),
                )
                bar.refresh()


def _figures(progress: CycleProgress, rate: float) -> str:
    late = progress.lateness[-1] if progress.lateness else 0.0
    return (
        f"{rate:5.0f} Hz  lost {progress.lost}  missed {progress.missed}  late {late * 1e3:.2f} ms  "
        f"following error {progress.following_error * 1e3:.2f} mrad"
    )


def figures(result: Result) -> dict[str, Any]:
    """Figures of a finished run, for `--json`: lateness in seconds, following error in rad."""
    progress = result.progress
    return {
        "cycles": progress.cycles,
        "answers_lost": progress.lost,
        "cycles_missed": progress.missed,
        "frames_sent": result.frames_sent,
        "frames_received": result.frames_received,
        "lateness": lateness_quantiles(np.array(progress.lateness)),
        "following_error_max": progress.following_error,
    }


def heard_summary(found: Mapping[str, Any]) -> Table:
    """Table of the figures of what was heard."""
    lost = ", ".join(map(str, found["answers_lost"]))
    period = f"{found['cycles']} cycles of {found['period_s']:.4g} s" if found["period_s"] else "does not repeat"
    configured = found["configured_rate_hz"]
    rig_file = "as" if found["rate_hz"] == configured else f"{configured:g} Hz"
    table = Table.grid(padding=(0, 2))
    table.add_row("SYNCs", f"{found['syncs']} heard, {found['syncs_missing']} missing")
    table.add_row("CAN frames", f"{found['frames']} heard")
    table.add_row("samples", f"{found['samples']}; answers lost of each joint: {lost}")
    table.add_row("rate", f"{found['rate_hz']:.6g} Hz, {rig_file} in the rig file")
    table.add_row("time stamps", found["stamps"])
    table.add_row("motion", f"{found['trajectory'] or 'not known'}, {period}")
    table.add_row("drives", "simulated: no real robot moved" if found["simulated"] else "not said to be simulated")
    return table


def summary(result: Result) -> Table:
    """Table of the same figures for the terminal."""
    values = figures(result)
    late = {key: f"{value * 1e3:.2f}" for key, value in values["lateness"].items()}
    table = Table.grid(padding=(0, 2))
    table.add_row("cycles (SYNC)", f"{values['cycles']}, {values['cycles_missed']} missed by the host")
    table.add_row("answers lost", f"{values['answers_lost']} of {values['cycles'] * len(result.identities)}")
    table.add_row("CAN frames", f"{values['frames_sent']} sent, {values['frames_received']} received")
    table.add_row("lateness", f"median {late['p50']} ms, 99 % {late['p99']} ms, worst {late['max']} ms")
    table.add_row("following error", f"worst {values['following_error_max'] * 1e3:.2f} mrad")
    return table
