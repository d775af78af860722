"""Our own recordings as tables, with columns named as in CSV import."""

from pathlib import Path

from recordings.columns import columns
from recordings.container import MAGIC
from recordings.files import sha256
from recordings.importing.table import Table
from recordings.reader import is_foreign, read
from recordings.recording import Recording


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
    return recording, Table(path, columns(recording), sha256(path))
