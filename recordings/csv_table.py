"""Reader of numeric CSV files that are written for this program: commas, a header, SI units; no layout is guessed."""

import csv
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from recordings.errors import BadInput, file_errors
from recordings.files import sha256
from recordings.importing.layout import TextLayout, table_of_lines
from recordings.importing.table import Table
from recordings.limits import check_columns, check_lines


def read_table(path: Path) -> Table:
    """Read a comma-separated file with a header row; empty cells are NaN, all other values are finite.

    Another thread, such as a cycle in real time, can go on between two blocks of lines.

    Raises:
        BadInput: the file is missing or unreadable, a column name is empty or a duplicate, the number of cells in a
            line differs from the header, or a cell is not a finite number, empty or NaN.
    """
    try:
        with file_errors(str(path)), path.open(encoding="utf-8-sig") as stream:
            lines = [line.rstrip("\n") for line in stream]
    except UnicodeDecodeError:
        raise BadInput(f"{path}: text in UTF-8 expected; save the file as UTF-8 CSV") from None
    while lines and not lines[-1].strip():
        lines.pop()
    table = table_of_lines(path, lines, TextLayout(",", _names(path, lines), first=1, marks="."))
    for name in (*table.invalid, *table.columns):
        table.column(name)  # says which cell is no finite number
    return replace(table, digest=sha256(path))


def _names(path: Path, lines: Sequence[str]) -> tuple[str, ...]:
    header = lines[0].strip() if lines else ""
    check_lines([header], f"{path}, line 1")
    if not header:
        raise BadInput(f"{path}, line 1: a header row with the names of the columns expected, none found")
    names = [name.strip() for name in next(csv.reader([header]))]
    check_columns(len(names), f"{path}, line 1")
    if len(names) == 1 and (";" in header or "\t" in header):
        raise BadInput(f"{path}, line 1: commas between columns expected, {header[:40]!r} found; convert the file")
    for name in names:
        if not name or names.count(name) > 1:
            problem = f"{name!r} twice" if name else "an empty one"
            raise BadInput(f"{path}, line 1: every column needs a name of its own, {problem} found")
    return tuple(names)
