"""Parquet, one row group for each chunk: for long paths. A gap is null."""

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from recordings.errors import BadInput
from recordings.recording import Floats


def write(tables: Iterable[dict[str, Floats]], path: Path) -> int:
    """Write the columns of all `tables`; return the number of rows.

    Raises:
        BadInput: pyarrow is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise BadInput(
            "Parquet needs the package pyarrow, which is not installed; install it with "
            "`pip install 'delta-workbench[parquet]'`, or choose csv"
        ) from None
    rows, writer = 0, None
    with ExitStack() as stack:
        for columns in tables:
            table = pyarrow.table({name: pyarrow.array(values, from_pandas=True) for name, values in columns.items()})
            if writer is None:
                writer = stack.enter_context(_writer(pyarrow.parquet, path, table.schema))
            writer.write_table(table)
            rows += len(table)
    return rows


def _writer(parquet: Any, path: Path, schema: Any) -> Any:
    """Torques hardly ever repeat: dictionaries of them only take time, and a stronger compression saves little."""
    return parquet.ParquetWriter(path, schema, use_dictionary=False, compression="snappy")
