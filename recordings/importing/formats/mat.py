"""MATLAB files: version 5 by scipy, version 7.3 (HDF5) by h5py.

Fields of a structure get names such as `log.q`; a matrix becomes one column per joint.
"""

import math
import struct
import zlib
from collections.abc import Iterator, Mapping
from os import SEEK_CUR
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import digest, reason
from recordings.importing.table import BagPart, Table
from recordings.limits import NUMBER, Allowance

_HDF5 = b"MATLAB 7.3 MAT-file"
_HEAD, _TAG, _COMPRESSED = 128, 8, 15
"""Of version 5: sizes of the header and of the tag of an element [bytes], type of an element that is compressed."""
_BLOCK = 1 << 20
_ENTRY = 1000
"""Memory that an entry of HDF5 takes beside its values [bytes]: groups may hold themselves."""
_MOST_LEVELS = 8
"""Depth of nested structures that are searched."""


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"MATLAB") or (path.suffix.lower() == ".mat" and b"\0" in head)


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    with path.open("rb") as stream:
        hdf5 = stream.read(len(_HDF5)) == _HDF5
    content = _read_hdf5(path) if hdf5 else _read_version_5(path)
    return table_of_arrays(path, dict(_leaves("", content)), digest(path))


def _read_version_5(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    try:
        _check_size(path)
        content: Mapping[str, Any] = loadmat(path, simplify_cells=True)
    except Exception as error:  # at damaged files it raises errors of every kind
        raise BadInput(f"{path} cannot be read as a MATLAB file: {reason(error)}; save it with -v7") from None
    return content


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


def _read_hdf5(path: Path) -> Mapping[str, Any]:
    try:
        import h5py
    except ImportError:
        raise BadInput(
            f"{path}: h5py reads MATLAB 7.3 files, and is not there; pip install 'delta-workbench[mat73]', or save "
            "with -v7"
        ) from None
    try:
        with h5py.File(path) as file:
            allowance = Allowance()
            allowance.take(0, path.stat().st_size)
            return _loaded(file, _MOST_LEVELS, allowance)
    except Exception as error:  # at damaged files it raises errors of every kind
        raise BadInput(f"{path} cannot be read as a MATLAB file: {reason(error)}; save it with -v7") from None


def _loaded(group: Any, levels: int, allowance: Allowance) -> dict[str, Any]:
    """Contents of an HDF5 group; MATLAB keeps its matrices transposed there."""
    content: dict[str, Any] = {}
    for name, item in group.items():
        allowance.take(_ENTRY)
        if hasattr(item, "items"):
            if levels and not name.startswith("#"):
                content[name] = _loaded(item, levels - 1, allowance)
        elif item.attrs.get("MATLAB_class") != b"char" and item.dtype.kind in "fiub":
            allowance.take(NUMBER * max(item.size, math.prod(item.chunks or ())))
            content[name] = item[()].T
    return content


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
