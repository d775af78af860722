"""Text tables of any make: delimiter, decimal mark, comments, preamble and units are found from the file."""

import re
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.importing.dates import seconds
from recordings.importing.formats import digest
from recordings.importing.table import BagPart, Table
from recordings.importing.text import TextLayout, decode, find_layout, is_comment, lines_of, number, split
from recordings.recording import Floats

_END_MARKS = ("EOF", "END")


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return not path.is_dir() and (b"\0" not in head or head.startswith((b"\xff\xfe", b"\xfe\xff")))


def read(path: Path, selection: BagPart) -> Table:
    """See `ImportFormat`."""
    lines = lines_of(decode(path.read_bytes(), path))
    while lines and (not lines[-1].strip() or lines[-1].strip() in _END_MARKS):
        lines.pop()
    layout = find_layout(path, lines)
    columns = _fast(lines[layout.first :], layout)
    if columns is not None:
        return Table(path, columns, digest(path), layout.units, first_line=layout.first + 1)
    return _careful(path, lines, layout)


def _fast(lines: Sequence[str], layout: TextLayout) -> dict[str, Floats] | None:
    """Columns of a table that holds nothing but numbers and gaps; None where it holds more."""
    if not lines:
        return None
    text = "\n".join(lines)
    if re.search(r"""["#%!']|//|\n\s*\n""", text):
        return None
    if layout.delimiter == " ":
        delimiter = None
    else:
        delimiter = layout.delimiter
        # Twice: neighbouring empty cells share a delimiter.
        empty = re.compile(rf"(^|{re.escape(delimiter)})[^\S\n\t]*(?={re.escape(delimiter)}|$)", re.MULTILINE)
        text = empty.sub(r"\1nan", text)
    if layout.decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".")
    try:
        numbers = np.loadtxt(StringIO(text), delimiter=delimiter, comments=None, ndmin=2)
    except ValueError:
        return None
    if len(numbers) != len(lines) or numbers.shape[1] != len(layout.names):
        return None
    return dict(zip(layout.names, numbers.T.copy(), strict=True))


def _careful(path: Path, lines: Sequence[str], layout: TextLayout) -> Table:
    """Read a table line by line: with text, dates, comments, or mistakes, which are named."""
    rows: list[list[str]] = []
    places: list[int] = []
    for place, line in enumerate(lines[layout.first :], start=layout.first + 1):
        if is_comment(line):
            continue
        cells = split(line, layout.delimiter) if line.strip() else []
        if len(cells) != len(layout.names):
            raise BadInput(
                f"{path}, line {place}: {len(layout.names)} cells as in the header expected, {len(cells)} found; "
                "complete or remove the line"
            )
        rows.append(cells)
        places.append(place)
    return _table_of_cells(path, rows, places, layout)


def _table_of_cells(path: Path, rows: list[list[str]], places: list[int], layout: TextLayout) -> Table:
    columns: dict[str, Floats] = {}
    invalid: dict[str, str] = {}
    labels: dict[str, NDArray[Any]] = {}
    start = None
    for name, cells in zip(layout.names, zip(*rows, strict=True) if rows else [()] * len(layout.names), strict=True):
        values = [number(cell, layout.decimal) for cell in cells]
        if None not in values:
            columns[name] = np.array(values, dtype=float)
        elif (dates := seconds(cells)) is not None:
            columns[name], start = dates
        else:
            row = values.index(None)
            labels[name] = np.array(cells)
            invalid[name] = (
                f"{path}, line {places[row]}, column {name!r}: a number expected, {cells[row][:40]!r} found; "
                "correct the cell, or leave it empty for a gap"
            )
    follow = bool(places) and places[-1] - places[0] == len(places) - 1  # else comments stand between them
    first_line = places[0] if follow else None
    return Table(path, columns, digest(path), layout.units, start, invalid, first_line, labels)
