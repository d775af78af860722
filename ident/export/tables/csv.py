"""CSV with a header row and full precision; an empty cell is a gap."""

from collections.abc import Iterable
from pathlib import Path

from recordings.recording import Floats


def write(tables: Iterable[dict[str, Floats]], path: Path) -> int:
    """Write the columns of all `tables`; return the number of rows."""
    rows = 0
    with path.open("w", encoding="utf-8", newline="") as stream:
        for table in tables:
            if not rows:
                stream.write(",".join(table) + "\n")
            cells = [_cells(column) for column in table.values()]
            stream.write("\n".join(map(",".join, zip(*cells, strict=True))) + "\n")
            rows += len(cells[0])
    return rows


def _cells(column: Floats) -> list[str]:
    return ["" if value != value else repr(value) for value in column.tolist()]
