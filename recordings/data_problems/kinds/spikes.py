"""Single samples far outside of all others, which are weighted out: a lost bit or frame, not a motion."""

from collections.abc import Iterator

import numpy as np

from recordings.data_problems import DataProblem, healing_command
from recordings.outliers import outlying
from recordings.recording import Recording


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


def _spikes(recording: Recording) -> Iterator[tuple[int, str]]:
    """Yield joints (from 0) with spikes, and how many there are where."""
    for name, values, marks in outlying(recording):
        for joint, column in enumerate(values.T):
            rows = np.flatnonzero(marks[:, joint])
            if len(rows):
                count = f"{len(rows)} sample{'s' if len(rows) > 1 else ''}"
                first = f"the first {column[rows[0]]:.3g} at {recording.time[rows[0]]:.3f} s"
                yield joint, f"{name} {joint + 1}: {count}, {first}"
