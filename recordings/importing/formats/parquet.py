"""Parquet, by pyarrow."""

from pathlib import Path

from recordings.importing.arrays import table_of_arrow
from recordings.importing.formats import digest, library, reading
from recordings.importing.table import BagPart, Table


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"PAR1")


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    parquet = library("pyarrow.parquet", path, "Parquet", "parquet")
    with reading(path, "Parquet", "export it again"):
        return table_of_arrow(path, parquet.read_table(path), digest(path))
