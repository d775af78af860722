"""A recording as named columns: the form of CSV and Parquet files, see "CSV import" in README."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Recording

JOINT_COLUMNS = ("position", "velocity", "command", "voltage", "effort")
"""One column per joint each, in SI units: position_1, position_2, ..."""


def columns(recording: Recording) -> dict[str, NDArray[Any]]:
    """Name: (n,) in the order of the file. Gaps are NaN; what was not measured at all is left out."""
    table: dict[str, NDArray[Any]] = {"time": recording.time}
    for name in JOINT_COLUMNS:
        values = getattr(recording, name)
        if values is not None and not np.isnan(values).all():
            table |= numbered(name, values)
    return table | {"cycle": recording.repeat} | dict(recording.extra)


def numbered(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """`values` (n, dof) as columns name_1 ... name_dof."""
    return {f"{name}_{i}": column for i, column in enumerate(values.T, start=1)}
