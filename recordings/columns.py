"""Table of named columns of a recording, as in CSV and Parquet files; see docs/reference/recordings.md."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Recording

JOINT_COLUMNS = ("position", "velocity", "command", "voltage", "effort")
"""Quantities with one column per joint (position_1, position_2, ...), in SI units."""


def columns(recording: Recording) -> dict[str, NDArray[Any]]:
    """Columns (n,) by name, in the order of the file. Gaps are NaN; quantities never measured are left out."""
    table: dict[str, NDArray[Any]] = {"time": recording.time}
    for name in JOINT_COLUMNS:
        values = getattr(recording, name)
        if values is not None and not np.isnan(values).all():
            table |= numbered(name, values)
    return table | {"cycle": recording.repeat} | dict(recording.extra)


def csv_rows(table: Iterable[NDArray[Any]]) -> str:
    """Rows of the columns (n,) of a `table`, with full precision; a gap is an empty cell."""
    cells = (["" if value != value else repr(value) for value in column.tolist()] for column in table)
    return "\n".join(map(",".join, zip(*cells, strict=True))) + "\n"


def numbered(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Columns name_1 ... name_dof of `values` (n, dof)."""
    return {f"{name}_{i}": column for i, column in enumerate(values.T, start=1)}
