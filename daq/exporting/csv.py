"""CSV export as `daq import` reads it: time [s], position_i [rad or m], voltage_i [V], effort_i [N m, N], cycle, ...

An empty cell is a gap. Numbers are written with full precision, so that reading returns the same values.
"""

import csv
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO

from recordings.columns import columns, csv_rows
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
        text.write(csv_rows(column[first : first + _ROWS] for column in table.values()))
    text.detach()
    return f"{count} samples, {len(table)} columns"
