"""JSON: one list for each column; null is a gap."""

import json
from collections.abc import Iterable
from pathlib import Path

from recordings.recording import Floats


def write(tables: Iterable[dict[str, Floats]], path: Path) -> int:
    """Write the columns of all `tables`; return the number of rows."""
    columns: dict[str, list[float | None]] = {}
    for table in tables:
        for name, values in table.items():
            cells = (None if value != value else value for value in values.tolist())
            columns.setdefault(name, []).extend(cells)
    path.write_text(json.dumps({"schema": 1, "columns": columns}) + "\n", encoding="utf-8")
    return len(columns["time"])
