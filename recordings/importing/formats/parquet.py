"""Parquet, by pyarrow; a column of lists of one length becomes a column per element."""

from pathlib import Path

from recordings.errors import BadInput
from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import digest, reason
from recordings.importing.table import BagPart, Table


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"PAR1")


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    try:
        from pyarrow import ArrowException, parquet
    except ImportError:
        raise BadInput(
            f"{path}: pyarrow reads Parquet, and is not there; pip install 'delta-workbench[parquet]'"
        ) from None
    try:
        content = parquet.read_table(path)
    except (ArrowException, OSError) as error:
        raise BadInput(f"{path} cannot be read as Parquet: {reason(error)}; export it again") from None
    columns = {name: content[name].combine_chunks() for name in content.column_names}
    arrays = {name: column.to_numpy(zero_copy_only=False) for name, column in columns.items()}
    return table_of_arrays(path, arrays, digest(path))
