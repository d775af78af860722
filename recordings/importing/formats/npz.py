"""NumPy archives (`numpy.savez`), without pickled objects."""

from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import digest, reason
from recordings.importing.table import BagPart, Table
from recordings.limits import NUMBER, Allowance


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"PK\x03\x04") and b".npy" in head[:1024]


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    allowance, arrays = Allowance(), {}
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            for entry in archive.zip.infolist():
                allowance.take(entry.file_size, entry.compress_size)
            for name in archive.files:
                arrays[name] = archive[name]
                allowance.take(NUMBER * arrays[name].size)
    except Exception as error:  # at damaged files it raises errors of every kind
        raise BadInput(f"{path} cannot be read as NPZ: {reason(error)}; save plain arrays with numpy.savez") from None
    return table_of_arrays(path, arrays, digest(path))
