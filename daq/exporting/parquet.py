"""Export to Parquet: the columns of the CSV file, with statusword_i, error_code_i and lateness; a gap is null.

The metadata of the schema hold the rig description (`rig`) and the run (`run`) as JSON.
"""

from pathlib import Path
from typing import BinaryIO

from recordings.columns import columns, numbered
from recordings.errors import BadInput
from recordings.reader import read


def write(file: Path, stream: BinaryIO) -> str:
    """See `ExportFormat`."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise BadInput(
            "Parquet needs the package pyarrow, which is not installed; install it with "
            "`pip install 'delta-workbench[parquet]'`, or export csv or mat"
        ) from None
    recording = read(file)
    columns_by_name = columns(recording)
    columns_by_name |= numbered("statusword", recording.statusword) | numbered("error_code", recording.error_code)
    columns_by_name |= {"lateness": recording.lateness}
    table = pyarrow.table({name: pyarrow.array(values, from_pandas=True) for name, values in columns_by_name.items()})
    described = {"rig": recording.rig.model_dump_json(), "run": recording.run.model_dump_json()}
    pyarrow.parquet.write_table(table.replace_schema_metadata(described), stream)
    return f"{len(recording.time)} samples, {len(columns_by_name)} columns"
