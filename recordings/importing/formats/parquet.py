"""Parquet, by pyarrow."""

from pathlib import Path
from typing import Any

from recordings.importing.arrays import table_of_arrow
from recordings.importing.formats import library, reading
from recordings.importing.table import Table
from recordings.limits import NUMBER, Allowance


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"PAR1")


def _check_size(metadata: Any) -> None:
    """Check the number and the size of the values that the file declares."""
    allowance = Allowance()
    for group in map(metadata.row_group, range(metadata.num_row_groups)):
        for column in map(group.column, range(group.num_columns)):
            size = max(NUMBER * column.num_values, column.total_uncompressed_size)
            allowance.take(size, column.total_compressed_size)


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    parquet = library("pyarrow.parquet", path, "Parquet", "parquet")
    with reading(path, "Parquet", "export it again"), parquet.ParquetFile(path) as file:
        _check_size(file.metadata)
        return table_of_arrow(path, file.read())
