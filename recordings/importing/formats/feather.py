"""Feather (Arrow IPC), by pyarrow."""

from pathlib import Path

from recordings.importing.arrays import table_of_arrow
from recordings.importing.formats import library, reading
from recordings.importing.table import Table


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith((b"ARROW1", b"FEA1"))


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    feather = library("pyarrow.feather", path, "Feather", "parquet")
    with reading(path, "Feather", "export it again"):
        return table_of_arrow(path, feather.read_table(path))
