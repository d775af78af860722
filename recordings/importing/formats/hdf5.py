"""HDF5, by h5py, which MATLAB 7.3 files are, too.

A dataset in a group gets a name such as `log.q`; the fields of a table, and a matrix, become one column each. Units
are taken from an attribute `unit` or `units`.
"""

import math
from pathlib import Path
from typing import Any

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import library, reading
from recordings.importing.table import Table
from recordings.limits import Allowance

_ENTRY = 1000
"""Memory that an entry takes beside its values [bytes]: groups may hold themselves."""
_SIGNATURES = (b"\x89HDF\r\n\x1a\n", b"MATLAB 7.3 MAT-file")


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(_SIGNATURES)


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    h5py = library("h5py", path, "HDF5 and MATLAB 7.3", "hdf5")
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}
    allowance = Allowance()
    allowance.take(0, path.stat().st_size)

    def take(place: str, item: Any) -> None:
        name = place.replace("/", ".")
        allowance.take(_ENTRY)
        # MATLAB keeps references below "#refs#".
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        allowance.take(item.dtype.itemsize * max(item.size, math.prod(item.chunks or ())))
        content, matlab_class = item[()], item.attrs.get("MATLAB_class")
        if item.dtype.names:
            arrays.update({f"{name}.{field}": content[field] for field in item.dtype.names})
        elif matlab_class != b"char":
            arrays[name] = content if matlab_class is None else content.T  # MATLAB keeps its matrices transposed
        for key, unit in item.attrs.items():
            if key.lower() in ("unit", "units") and isinstance(unit, str | bytes):
                units[name] = unit if isinstance(unit, str) else unit.decode("utf-8", "replace")

    with reading(path, "HDF5", "export it again"), h5py.File(path) as file:
        file.visititems(take)
        return table_of_arrays(path, arrays, units)
