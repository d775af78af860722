"""Our own recordings as tables, with columns named as in CSV import."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from recordings.container import MAGIC
from recordings.files import sha256
from recordings.importing.table import Table
from recordings.reader import is_foreign, read
from recordings.recording import Floats, Recording

_SIGNALS = ("position", "command", "voltage", "velocity", "effort")


def recognises(path: Path) -> bool:
    """Whether `path` is a recording of ours: MCAP with the description of a rig."""
    if not path.is_file() or path.suffix != ".mcap":
        return False
    with path.open("rb") as stream:
        return stream.read(len(MAGIC)) == MAGIC and not is_foreign(path)


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
