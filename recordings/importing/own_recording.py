"""Our own recordings as tables, with columns named as in CSV import."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from recordings.files import sha256
from recordings.importing.table import Table
from recordings.reader import read
from recordings.recording import Floats, Recording

SUFFIX = ".mcap"
_SIGNALS = ("position", "command", "voltage", "velocity", "effort")


def table(path: Path) -> tuple[Recording, Table]:
    """Read the recording `path`.

    Raises:
        BadInput: it is none, or is damaged.
    """
    recording = read(path)
    columns = {"time": recording.time, **dict(_columns(recording)), **recording.extra}
    return recording, Table(path, columns, sha256(path))


def _columns(recording: Recording) -> Iterator[tuple[str, Floats]]:
    for name in _SIGNALS:
        values = getattr(recording, name)
        if values is not None and np.isfinite(values).any():
            yield from ((f"{name}_{joint}", column) for joint, column in enumerate(values.T, 1))
