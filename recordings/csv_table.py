"""Reader of numeric CSV files; errors name the line and the column."""

import csv
import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.files import sha256
from recordings.limits import check_columns, check_lines
from recordings.recording import Floats

_ROWS = 500
"""Number of lines that are parsed at a time: a few milliseconds, in which no other thread goes on."""


@dataclass(frozen=True, eq=False)
class CsvTable:
    """Named columns of numbers; row k is line k + 2 of the file."""

    path: Path
    columns: dict[str, Floats]
    """Columns (n,) by name. Empty cells are NaN; all other values are finite."""
    digest: str
    """SHA-256 of the file."""

    def location(self, row: int, name: str | None = None) -> str:
        """Position of a row, or of one cell, for error messages."""
        return f"{self.path}, line {row + 2}{f', column {name!r}' if name else ''}"


def read_table(path: Path) -> CsvTable:
    """Read a comma-separated file with a header row.

    Another thread, such as a cycle in real time, can go on between two blocks of lines.

    Raises:
        BadInput: the file is missing or unreadable, a column name is empty or a duplicate, the number of cells in a
            line differs from the header, or a cell is not a finite number, empty or NaN.
    """
    try:
        with path.open(encoding="utf-8-sig") as stream:
            header = stream.readline().strip()
            check_lines([header], f"{path}, line 1")
            names = _names(path, header)
            blocks = list(_blocks(path, stream, names))
        digest = sha256(path)
    except FileNotFoundError:
        raise BadInput(f"{path} does not exist; check the path") from None
    except UnicodeDecodeError:
        raise BadInput(f"{path}: text in UTF-8 expected; save the file as UTF-8 CSV") from None
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}") from None
    numbers = np.concatenate([np.empty((0, len(names))), *blocks])
    return CsvTable(path, dict(zip(names, numbers.T.copy(), strict=True)), digest)


def _names(path: Path, header: str) -> list[str]:
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
    return names


def _blocks(path: Path, lines: Iterator[str], names: Sequence[str]) -> Iterator[Floats]:
    """Yield the numbers (m, k) of up to `_ROWS` lines at a time."""
    first = 2
    while block := list(islice(lines, _ROWS)):
        yield _numbers(path, block, names, first)
        first += len(block)


def _numbers(path: Path, lines: Sequence[str], names: Sequence[str], first: int) -> Floats:
    """Numbers (m, k) of lines, of which the first is line `first` of the file."""
    if all(line.strip() for line in lines):
        with suppress(ValueError):
            numbers = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
            if numbers.shape == (len(lines), len(names)) and not np.isinf(numbers).any():
                return numbers
    # With gaps, or mistakes, which are named.
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    rows = [_row(path, place, line, names) for place, line in enumerate(lines, start=first)]
    return np.array(rows, dtype=float).reshape(-1, len(names))


def _row(path: Path, place: int, line: str, names: Sequence[str]) -> list[float]:
    cells = line.strip().split(",") if line.strip() else []
    if len(cells) != len(names):
        raise BadInput(f"{path}, line {place}: {len(names)} cells as in the header expected, {len(cells)} found")
    row = []
    for name, cell in zip(names, cells, strict=True):
        try:
            row.append(float(cell) if cell.strip() else math.nan)
        except ValueError:
            row.append(math.inf)
        if math.isinf(row[-1]):
            raise BadInput(f"{path}, line {place}, column {name!r}: a number expected, {cell.strip()[:40]!r} found")
    return row
