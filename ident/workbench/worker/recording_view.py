"""View of a recording before any fit: metadata, quality and signals."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ident.data.compatibility import check_same_rig
from ident.data.samples import drive_signal, holds_torque
from ident.workbench.worker.views import Mismatch, RecordingView
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Recording

_SIGNAL_NAMES = {"V": "voltage", "N": "force"}
_WARNING_LEVELS = ("warning", "error", "fatal")
PREVIEW_BYTES = 12_000_000
"""Bytes of a long recording that are shown while the rest is read: about a minute at 500 Hz."""


def recording_views(path: Path) -> Iterator[RecordingView]:
    """Yield the view of a recording; for a long one first the view of its beginning.

    Raises:
        BadInput: the file is not a recording.
    """
    if path.stat().st_size > 2 * PREVIEW_BYTES:
        yield _recording_view(read(path, PREVIEW_BYTES), ("Only the beginning is shown; the rest is being read.",))
    recording = read(path)
    yield _recording_view(recording, tuple(_warnings(recording)))


def mismatch(train: Path, validate: Path) -> Iterator[Mismatch]:
    """Yield the reason why a model of `train` cannot be validated on `validate`, if there is one."""
    try:
        check_same_rig([read(path, PREVIEW_BYTES) for path in (train, validate)])
    except BadInput as error:
        yield Mismatch(f"{validate.name} cannot validate a model of {train.name}: {error}")


def _recording_view(recording: Recording, warnings: tuple[str, ...]) -> RecordingView:
    rig = recording.rig
    length = rig.position_units[0]
    unit = rig.effort_units[0] if holds_torque(recording) else "V"
    signals = {
        "position": (length, recording.position),
        "following error": (f"m{length}", 1e3 * recording.following_error),
        _SIGNAL_NAMES.get(unit, "torque"): (unit, drive_signal(recording)),
        "lateness": ("ms", 1e3 * recording.lateness[:, None]),
    }
    return RecordingView(
        name=recording.path.name,
        quality=_quality(recording),
        warnings=warnings,
        events=tuple((event.time, event.level, event.source, event.message) for event in recording.events),
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        time=recording.time,
        signals={name: (unit, values.astype(np.float32)) for name, (unit, values) in signals.items()},
    )


def _quality(recording: Recording) -> dict[str, str]:
    run, time, gaps, rig = recording.run, recording.time, recording.gaps, recording.rig
    lateness = 1e3 * recording.lateness[np.isfinite(recording.lateness)]
    error = 1e3 * np.abs(recording.following_error)
    worst_error = np.nanmax(error, initial=0.0, where=np.isfinite(error))
    quality = {
        "Rig": rig.name,
        "Drives": "simulated: no real robot moved" if run.simulated else "real",
        "Motion": f"{run.trajectory}, {run.cycles} × {run.period:g} s" if run.period else run.trajectory,
        "Length": f"{time[-1] - time[0]:.2f} s, {len(time)} samples at {run.rate:g} Hz",
        "Lost samples": ", ".join(f"joint {j}: {n}" for j, n in enumerate(gaps, 1)) if gaps.any() else "none",
        "Lateness": f"median {np.median(lateness):.2f} ms, worst {lateness.max():.2f} ms" if len(lateness) else "",
        "Following error": f"worst {worst_error:.2f} m{rig.position_units[0]}" if np.isfinite(error).any() else "",
        "Torque gain": "calibrated" if rig.torque.gain_source == "calibrated" else "assumed: torques are relative",
        "Recorded": f"{run.start}, by {run.software}",
        "Ended": "interrupted" if run.exit_status is None else f"{run.reason} (exit status {run.exit_status})",
    }
    return {label: value for label, value in quality.items() if value}


def _warnings(recording: Recording) -> Iterator[str]:
    if not recording.complete:
        yield "The recording was interrupted; the data up to there are intact."
    elif recording.run.exit_status:
        yield f"The run did not end as planned: {recording.run.reason}"
    if recording.gaps.any():
        yield f"{int(recording.gaps.sum())} samples were lost; they are excluded, not interpolated."
    problems = [event for event in recording.events if event.level in _WARNING_LEVELS]
    if problems:
        yield f"{len(problems)} warnings and errors occurred while recording; see the events."
