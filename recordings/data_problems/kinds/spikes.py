"""Single samples far outside of all others, which are weighted out: a lost bit or frame, not a motion."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from recordings.data_problems import DataProblem, healing_command
from recordings.outliers import outliers, without_outliers
from recordings.recording import Floats, Recording


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if any sample of a position or a torque is a spike."""
    found = [*_spikes(recording)]
    if not found:
        return None
    return DataProblem(
        kind="spikes",
        joints=tuple(sorted({joint + 1 for joint, _ in found})),
        blocks=False,
        why=f"Single samples far outside of all others are left out: {'; '.join(text for _, text in found)}.",
        remedy=healing_command(recording.path, ["--drop-outliers"]),
    )


def without_spikes(recording: Recording) -> Recording:
    """The `recording` with gaps in place of spikes."""
    for name, values in _signals(recording):
        recording = replace(recording, **{name: without_outliers(values)})  # type: ignore[arg-type]  # the three are arrays
    return recording


def _spikes(recording: Recording) -> Iterator[tuple[int, str]]:
    """Yield joints (from 0) with spikes, and how many there are where."""
    for name, values in _signals(recording):
        for joint, column in enumerate(values.T):
            rows = np.flatnonzero(outliers(column))
            if len(rows):
                count = f"{len(rows)} sample{'s' if len(rows) > 1 else ''}"
                first = f"the first {column[rows[0]]:.3g} at {recording.time[rows[0]]:.3f} s"
                yield joint, f"{name} {joint + 1}: {count}, {first}"


def _signals(recording: Recording) -> Iterator[tuple[str, Floats]]:
    """Yield the measured signals (n, dof) that a diagnosis uses and that have spikes."""
    for name in ("position", "voltage", "effort"):
        values = getattr(recording, name)
        if values is not None and any(outliers(column).any() for column in values.T):
            yield name, values
