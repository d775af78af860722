"""View of a recording before any fit: metadata, quality and signals."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ident.data.compatibility import check_same_rig
from ident.data.samples import drive_signal, holds_torque
from ident.data_problems import check_data
from ident.output.tables.recordings import facts
from ident.output.tables.recordings import warnings as warnings_of
from ident.workbench.worker.views import Mismatch, RecordingView
from recordings.columns import columns
from recordings.data_problems import DataProblem
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Recording

_SIGNAL_NAMES = {"V": "voltage", "N": "force"}
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
    yield _recording_view(recording, tuple(warnings_of(recording)), _problems(recording))


def _problems(recording: Recording) -> tuple[DataProblem, ...]:
    try:
        return check_data([recording]).data_problems
    except BadInput:  # it is shown all the same; a fit says why it cannot be used
        return ()


def mismatch(train: Path, validate: Path) -> Iterator[Mismatch]:
    """Yield the reason why a model of `train` cannot be validated on `validate`, if there is one."""
    try:
        check_same_rig([read(path, PREVIEW_BYTES) for path in (train, validate)])
    except BadInput as error:
        yield Mismatch(f"{validate.name} cannot validate a model of {train.name}: {error}")


def _recording_view(
    recording: Recording, warnings: tuple[str, ...], problems: tuple[DataProblem, ...] = ()
) -> RecordingView:
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
        quality=facts(recording),
        warnings=warnings,
        problems=problems,
        events=tuple((event.time, event.level, event.source, event.message) for event in recording.events),
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        time=recording.time,
        signals={name: (unit, values.astype(np.float32)) for name, (unit, values) in signals.items()},
        columns=tuple(columns(recording)),
    )
