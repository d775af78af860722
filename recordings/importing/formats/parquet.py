"""Parquet, by pyarrow; a column of lists of one length becomes a column per element."""

from pathlib import Path
from typing import Any

from recordings.errors import BadInput
from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import digest, reason
from recordings.importing.table import BagPart, Table
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


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise BadInput(
            f"{path}: pyarrow reads Parquet, and is not there; pip install 'delta-workbench[parquet]'"
        ) from None
    try:
        with parquet.ParquetFile(path) as file:
            _check_size(file.metadata)
            content = file.read()
        columns = {name: content[name].combine_chunks() for name in content.column_names}
        arrays = {name: column.to_numpy(zero_copy_only=False) for name, column in columns.items()}
    except (ArrowException, OSError, ValueError, MemoryError) as error:
        raise BadInput(f"{path} cannot be read as Parquet: {reason(error)}; export it again") from None
    return table_of_arrays(path, arrays, digest(path))
