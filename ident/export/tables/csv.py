"""CSV with a header row and full precision; an empty cell is a gap."""

from collections.abc import Iterable
from pathlib import Path

from recordings.columns import csv_rows
from recordings.recording import Floats


def write(tables: Iterable[dict[str, Floats]], path: Path) -> int:
    """Write the columns of all `tables`; return the number of rows."""
    rows = 0
    with path.open("w", encoding="utf-8", newline="") as stream:
        for table in tables:
            if not rows:
                stream.write(",".join(table) + "\n")
            stream.write(csv_rows(table.values()))
            rows += len(next(iter(table.values())))
    return rows
