"""Recordings of what is in memory or in another program's file: arrays, data frames, and paths."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from recordings.columns import numbered
from recordings.errors import BadInput, expect
from recordings.importing import Description, converted, of_table
from recordings.importing.arrays import table_of_arrays
from recordings.recording import Floats, Recording
from recordings.rig import Rig, load_rig

_TORQUES = ("effort", "voltage", "current")


def of_arrays(
    time: ArrayLike, position: ArrayLike, cycle: ArrayLike | None, rig: object, **others: ArrayLike | None
) -> Recording:
    """Make a recording of arrays, see `Recording.from_arrays`; others: (n, dof) by quantity, None if not measured."""
    if len(given := [name for name in _TORQUES if others[name] is not None]) != 1:
        raise BadInput(f"one of {', '.join(_TORQUES)} expected, {', '.join(given) or 'none'} found; give one of them")
    instants = real_array(time, "time")
    columns = {"time": instants} | ({} if cycle is None else {"cycle": real_array(cycle, "cycle")})
    joints = {name: real_array(x, name) for name, x in {"position": position, **others}.items() if x is not None}
    joints = {name: values[:, None] if values.ndim == 1 else values for name, values in joints.items()}
    shape = (instants.size, *joints["position"].shape[1:2])
    for name, values in joints.items():
        if values.shape != shape or len(shape) != 2:
            raise BadInput(
                f"{name}: an array (n, dof) of shape {shape} expected, {values.shape} found; give one row per time"
            )
        columns |= numbered(name, values)
    return of_columns("arrays", columns, None, rig)


def of_columns(name: str, columns: Mapping[str, NDArray[Any]], mapping: object, rig: object) -> Recording:
    """Make a recording, whose name begins with `name`, of columns (n,); see `Recording.from_frame`."""
    table = table_of_arrays(Path(name), columns)
    content = [part for key, values in table.columns.items() for part in (key.encode(), values.tobytes())]
    digest = hashlib.sha256(b"".join(content)).hexdigest()
    path = Path(f"{name}-{digest[:8]}")
    table = replace(table, path=path, digest=digest)
    return of_table(table, Description(rig=_described(rig)), _entries(mapping)).recording(path)


def of_file(path: Path, mapping: object, rig: object) -> Recording:
    """Read measurements of any format that `daq import` reads, without writing a recording."""
    return converted(path, Description(rig=_described(rig)), _entries(mapping)).recording(path)


def real_array(values: ArrayLike, name: str) -> Floats:
    """Return a copy of the argument `name`, so that nobody writes into the user's array.

    Raises:
        TypeError: it is no array of real numbers.
    """
    try:
        return np.array(values, float)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: an array of real numbers expected, {type(values).__name__} found") from None


def _entries(mapping: Any) -> tuple[str, ...]:
    """Entries NAME=COLUMN:UNIT of the argument `map`."""
    expect(Mapping | None, 'a mapping such as {"position_1": "q1:deg"}', map=mapping)
    return tuple(f"{name}={source}" for name, source in (mapping or {}).items())


def _described(rig: Any) -> Rig | None:
    """The rig that the argument `rig` is or names."""
    expect(str | Path | Rig | None, "a rig file or a rig", rig=rig)
    return load_rig(Path(rig), driven=False) if isinstance(rig, str | Path) else rig
