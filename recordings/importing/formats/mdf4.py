"""MDF, versions 3 and 4 (ASAM), by asammdf.

Channels are measured in groups of one raster each. The columns are at the instants of the group with the most
channels; channels of other groups are interpolated there.
"""

from collections import Counter
from contextlib import suppress
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import library, reading
from recordings.importing.table import Table, distinct
from recordings.interpolation import interpolate_within_gaps


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith((b"MDF     ", b"UnFinMF "))


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    asammdf = library("asammdf", path, "MDF4", "mdf4")
    asammdf.blocks.mdf_v4.MDF4.__del__ = _release
    with reading(path, "MDF", "export it again"), path.open("rb") as stream, asammdf.MDF(stream) as file:
        start, signals = file.start_time, list(file.iter_channels(skip_master=True))
    if not signals:
        return table_of_arrays(path, {})
    raster = Counter(signal.group_index for signal in signals).most_common(1)[0][0]
    instants = next(signal.timestamps for signal in signals if signal.group_index == raster)
    names = distinct(["time", *(signal.name for signal in signals)])[1:]
    arrays, other = {"time": instants}, []
    for name, signal in zip(names, signals, strict=True):
        arrays[name] = signal.samples
        if signal.group_index != raster and signal.samples.dtype.kind in "fiub" and signal.samples.ndim == 1:
            arrays[name] = interpolate_within_gaps(instants, signal.timestamps, signal.samples.astype(float))
            other.append(name)
    units = {name: signal.unit for name, signal in zip(names, signals, strict=True) if signal.unit}
    table = table_of_arrays(path, arrays, {"time": "s", **units})
    interpolated = (f"interpolated at the instants of the others: {', '.join(other)}",) if other else ()
    first = (start + timedelta(seconds=float(instants[0]))).isoformat(timespec="milliseconds")
    return replace(table, start=first, notes=(*table.notes, *interpolated))


def _release(file: Any) -> None:
    """Stands for the destructor of a file, which would fail, and be printed, where its constructor failed."""
    with suppress(AttributeError):
        file.close()
