"""CSV export as `daq import` reads it: time [s], position_i [rad or m], voltage_i [V], effort_i [N m, N], cycle, ...

An empty cell is a gap. Numbers are written with full precision, so that reading returns the same values.
"""

import csv
from io import TextIOWrapper
from pathlib import Path
from typing import Any, BinaryIO

from numpy.typing import NDArray

from recordings.columns import columns
from recordings.reader import read

_ROWS = 50_000
"""Number of rows that are formatted at a time."""


def write(file: Path, stream: BinaryIO) -> str:
    """See `ExportFormat`."""
    table = columns(read(file))
    count = len(table["time"])
    text = TextIOWrapper(stream, encoding="utf-8", newline="")
    csv.writer(text, lineterminator="\n").writerow(table)
    for first in range(0, count, _ROWS):
        cells = [_cells(column[first : first + _ROWS]) for column in table.values()]
        text.write("\n".join(map(",".join, zip(*cells, strict=True))) + "\n")
    text.detach()
    return f"{count} samples, {len(table)} columns"


def _cells(column: NDArray[Any]) -> list[str]:
    return ["" if value != value else repr(value) for value in column.tolist()]
