"""`daq info`: summary of a recording."""

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recordings.command_line import say_next
from recordings.errors import StoppedByAlarm

if TYPE_CHECKING:
    from recordings.recording import CanFrames, Recording, Run

_BAR_WIDTH = 40
_STOPPING = ("error", "fatal")
"""Levels of events that end a run."""


@click.command(epilog="Example: daq info run.mcap")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="One JSON document instead of a table.")
def command(file: Path, as_json: bool) -> None:
    """Show what a recording holds: the run, its timing, gaps, bus frames and events."""
    from recordings.reader import read, read_can

    recording = read(file)
    figures = _figures(recording, read_can(file))
    if as_json:
        click.echo(json.dumps(figures, indent=2, allow_nan=False))
    else:
        _show(figures, recording.run)
        say_next(*(("ident", "check") if recording.complete else ("daq", "recover")), file)


def _figures(recording: "Recording", frames: "CanFrames") -> dict[str, Any]:
    run, time = recording.run, recording.time
    return {
        "schema": 1,
        "file": str(recording.path),
        "rig": recording.rig.name,
        "robot": run.robot,
        "position_units": list(recording.rig.position_units),
        "simulated": run.simulated,
        "pace": run.pace,
        "seed": run.seed,
        "software": run.software,
        "start": run.start,
        "trajectory": run.trajectory,
        "trajectory_digest": run.trajectory_digest,
        "rate_hz": run.rate,
        "cycles": run.cycles,
        "period_s": run.period,
        "duration_s": float(time[-1] - time[0]),
        "samples": len(time),
        "gaps": recording.gaps.tolist(),
        "longest_gap_s": recording.longest_gap,
        **_following_error(recording),
        **_lateness(recording),
        "frames": {"sent": int(frames.sent.sum()), "received": int((~frames.sent).sum())},
        "events": [
            {"time_s": event.time, "level": event.level, "source": event.source, "message": event.message}
            for event in recording.events
            if event.level in ("warning", "error", "fatal")
        ],
        "feedforward": run.feedforward,
        "complete": run.exit_status == 0,
        "exit_status": run.exit_status,
        "reason": run.reason,
    }


def _lateness(recording: "Recording") -> dict[str, Any]:
    """Quantiles of the lateness and its histogram with bin edges in steps of 1-2-5, empty if no cycle was late."""
    import numpy as np

    from recordings.recording import lateness_quantiles

    late = recording.lateness[np.isfinite(recording.lateness)]
    if not late.size:
        return {"lateness_s": None, "lateness_histogram": []}
    edges = [step * 10.0**exponent for exponent in range(-5, 4) for step in (1, 2, 5)]
    counts = np.bincount(np.searchsorted(edges, late))
    bins = range(int(np.flatnonzero(counts)[0]), len(counts)) if late.any() else ()
    histogram = [{"up_to_s": edges[i], "cycles": int(counts[i])} for i in bins]
    return {"lateness_s": lateness_quantiles(late), "lateness_histogram": histogram}


def _following_error(recording: "Recording") -> dict[str, list[float] | None]:
    """Size of the following error of each joint [rad or m] during the motion, without its approach and what comes
    after the error that stopped it; None without commands."""
    import numpy as np

    stops = [event.time for event in recording.events if recording.run.exit_status and event.level in _STOPPING]
    moving = (recording.repeat >= 0) & (recording.time < min(stops, default=math.inf))
    error = recording.following_error[moving]
    known = np.isfinite(error)
    if not known.any(axis=0).all():
        return {"following_error_rms": None, "following_error_max": None}
    squares = np.mean(error**2, axis=0, where=known)
    largest = np.max(np.abs(error), axis=0, where=known, initial=0.0)
    return {"following_error_rms": np.sqrt(squares).tolist(), "following_error_max": largest.tolist()}


def _gaps(lost: list[int], longest: float) -> Iterator[str]:
    """Yield the lost samples of each joint, and the longest time [s] without any row."""
    if any(lost):
        yield ", ".join(f"joint {i}: {count}" for i, count in enumerate(lost, 1))
    if longest:
        yield f"up to {longest:.3f} s without rows"


def _rows(figures: dict[str, Any], run: "Run") -> list[tuple[str, str]]:
    gaps, frames, late = figures["gaps"], figures["frames"], figures["lateness_s"]
    seed = "" if figures["seed"] is None else f", seed {figures['seed']}"
    ended = "INTERRUPTED: the recording has no end; what it holds is intact"
    if run.exit_status is not None:
        outcome = {0: "done", StoppedByAlarm.exit_code: "STOPPED"}.get(run.exit_status, "FAILED")
        ended = f"{outcome}, exit status {figures['exit_status']}: {figures['reason']}"
    steps = figures["lateness_histogram"]
    most = max((step["cycles"] for step in steps), default=0)
    return [
        ("recording", figures["file"]),
        ("rig", figures["rig"]),
        *([("robot", figures["robot"])] if figures["robot"] else []),
        ("drives", run.drives_in_words),
        ("pace", f"{figures['pace']}{seed}"),
        ("start", run.start_in_words),
        ("software", figures["software"]),
        ("trajectory", f"{figures['trajectory']} ({figures['trajectory_digest'][:12]})"),
        ("rate", f"{figures['rate_hz']:g} Hz"),
        ("duration", f"{figures['duration_s']:.3f} s"),
        ("cycles", f"{figures['cycles']} of {figures['period_s']:g} s" if figures["period_s"] else "none found"),
        ("samples", str(figures["samples"])),
        ("gaps", "; ".join(_gaps(gaps, figures["longest_gap_s"])) or "none"),
        *_following_error_row(figures),
        *([("feed-forward", f"model or table {figures['feedforward'][:12]}")] if figures["feedforward"] else []),
        ("lateness", "not recorded" if late is None else ", ".join(f"{k} {v * 1e3:.3f} ms" for k, v in late.items())),
        *(
            (
                f"  up to {s['up_to_s'] * 1e3:g} ms",
                f"{s['cycles']:6} {'█' * math.ceil(_BAR_WIDTH * s['cycles'] / most)}",
            )
            for s in steps
        ),
        ("bus frames", f"{frames['sent']} sent, {frames['received']} received"),
        ("ended", ended),
    ]


def _following_error_row(figures: dict[str, Any]) -> list[tuple[str, str]]:
    if figures["following_error_max"] is None:
        return []
    pairs = zip(
        figures["following_error_rms"], figures["following_error_max"], figures["position_units"], strict=True
    )
    sizes = [f"{rms * 1e3:.2f} (worst {worst * 1e3:.2f}) m{unit}" for rms, worst, unit in pairs]
    return [("following error", ", ".join(f"joint {i}: {size}" for i, size in enumerate(sizes, 1)))]


def _show(figures: dict[str, Any], run: "Run") -> None:
    rows = _rows(figures, run)
    rows += [
        (event["level"], f"{event['time_s']:.3f} s {event['source']}: {event['message']}")
        for event in figures["events"]
    ]
    if not sys.stdout.isatty():
        for name, value in rows:
            click.echo(f"{name}: {value}")
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(show_header=False)
    for name, value in rows:
        loud = name in ("error", "fatal") or value.startswith(("SIMULATED", "INTERRUPTED", "FAILED"))
        # As `Text`: texts from a recording must not be parsed as markup.
        table.add_row(name, Text(value, style="bold red" if loud else ""))
    Console().print(table)
