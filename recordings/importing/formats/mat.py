"""MATLAB files up to version 7, by scipy; those of version 7.3 are HDF5.

Fields of a structure get names such as `log.q`; a matrix becomes one column per joint.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import digest, reading
from recordings.importing.table import BagPart, Table

_MOST_LEVELS = 8
"""Depth of nested structures that are searched."""


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"MATLAB") or (path.suffix.lower() == ".mat" and b"\0" in head)


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    from scipy.io import loadmat

    with reading(path, "a MATLAB file", "save it with -v7"):
        content: Mapping[str, Any] = loadmat(path, simplify_cells=True)
    return table_of_arrays(path, dict(_leaves("", content)), digest(path))


def _leaves(
    prefix: str, content: Mapping[str, Any], levels: int = _MOST_LEVELS
) -> Iterator[tuple[str, NDArray[Any]]]:
    """Arrays of a tree of structures, by their path in it."""
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, Mapping):
            if levels:
                yield from _leaves(f"{prefix}{name}.", value, levels - 1)
        else:
            yield f"{prefix}{name}", np.asarray(value)
