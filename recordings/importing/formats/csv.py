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
from recordings.importing.table import Table
from recordings.importing.text import TextLayout, decode, find_layout, is_comment, lines_of, number, split
from recordings.recording import Floats

_END_MARKS = ("EOF", "END")
_ROWS = 500
"""Number of lines that are parsed at a time: a few milliseconds, in which no other thread goes on."""


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    lines = lines_of(decode(path.read_bytes(), path))
    while lines and (not lines[-1].strip() or lines[-1].strip() in _END_MARKS):
        lines.pop()
    return table_of_lines(path, lines, find_layout(path, lines))


def table_of_lines(path: Path, lines: Sequence[str], layout: TextLayout) -> Table:
    """Make a table of the lines of a text in this layout.

    Raises:
        BadInput: the number of cells in a line differs from the header.
    """
    blocks = []
    for first in range(layout.first, len(lines), _ROWS):
        numbers = _fast(lines[first : first + _ROWS], layout)
        if numbers is None:
            return _careful(path, lines, layout)
        blocks.append(numbers)
    numbers = np.concatenate([np.empty((0, len(layout.names))), *blocks])
    columns = dict(zip(layout.names, numbers.T.copy(), strict=True))
    return Table(path, columns, layout.units, first_line=layout.first + 1)


def _fast(lines: Sequence[str], layout: TextLayout) -> Floats | None:
    """Numbers (m, k) of lines that hold nothing else but gaps; None where they hold more."""
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
    return numbers if numbers.shape == (len(lines), len(layout.names)) else None


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
    columns: dict[str, Floats] = {}
    invalid: dict[str, str] = {}
    labels: dict[str, NDArray[Any]] = {}
    start = None
    texts = zip(*rows, strict=True) if rows else [()] * len(layout.names)
    for name, text in zip(layout.names, texts, strict=True):
        values = [number(cell, layout.decimal) for cell in text]
        if None not in values:
            columns[name] = np.array(values, dtype=float)
        elif (dates := seconds(text)) is not None:
            columns[name], start = dates
        else:
            row = values.index(None)
            labels[name] = np.array(text)
            invalid[name] = (
                f"{path}, line {places[row]}, column {name!r}: a number expected, {text[row][:40]!r} found; "
                "correct the cell, or leave it empty for a gap"
            )
    follow = bool(places) and places[-1] - places[0] == len(places) - 1  # else comments stand between them
    first_line = places[0] if follow else None
    return Table(path, columns, layout.units, start, invalid, first_line, labels)
