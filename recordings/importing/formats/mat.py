"""MATLAB files up to version 7, by scipy; those of version 7.3 are HDF5.

Fields of a structure get names such as `log.q`; a matrix becomes one column per joint.
"""

import struct
import zlib
from collections.abc import Iterator, Mapping
from os import SEEK_CUR
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import reading
from recordings.importing.table import Table
from recordings.limits import NUMBER, Allowance

_HEAD, _TAG, _COMPRESSED = 128, 8, 15
"""Of version 5: sizes of the header and of the tag of an element [bytes], type of an element that is compressed."""
_BLOCK = 1 << 20
_MOST_LEVELS = 8
"""Depth of nested structures that are searched."""


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"MATLAB") or (path.suffix.lower() == ".mat" and b"\0" in head)


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    from scipy.io import loadmat

    with reading(path, "a MATLAB file", "save it with -v7"):
        _check_size(path)
        content: Mapping[str, Any] = loadmat(path, simplify_cells=True)
    return table_of_arrays(path, dict(_leaves("", content)))


def _check_size(path: Path) -> None:
    """Unpack the elements of a file of version 5 block by block, to see how large they become."""
    allowance = Allowance()
    with path.open("rb") as stream:
        order = "<" if stream.read(_HEAD)[-2:] == b"IM" else ">"
        while len(tag := stream.read(_TAG)) == _TAG:
            kind, size = struct.unpack(f"{order}II", tag)
            if kind != _COMPRESSED:
                stream.seek(size, SEEK_CUR)
                continue
            unpacking, rest = zlib.decompressobj(), stream.read(size)
            allowance.take(0, len(rest))
            while rest:
                # Each byte may be a number.
                allowance.take(NUMBER * len(unpacking.decompress(rest, _BLOCK)))
                rest = unpacking.unconsumed_tail


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
