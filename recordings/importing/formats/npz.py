"""NumPy archives (`numpy.savez`), without pickled objects."""

from pathlib import Path

import numpy as np

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import reading
from recordings.importing.table import Table
from recordings.limits import NUMBER, Allowance


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"PK\x03\x04") and b".npy" in head[:1024]


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    allowance, arrays = Allowance(), {}
    with (
        reading(path, "NPZ", "save plain arrays with numpy.savez"),
        path.open("rb") as stream,
        np.load(stream, allow_pickle=False) as archive,
    ):
        for entry in archive.zip.infolist():
            allowance.take(entry.file_size, entry.compress_size)
        for name in archive.files:
            arrays[name] = archive[name]
            allowance.take(NUMBER * arrays[name].size)
    return table_of_arrays(path, arrays)
