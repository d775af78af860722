"""Tables in text: what the rows say decides how they are read.

Delimiter, comments, header and units are found from it. What can be read in two ways is refused, never guessed.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.importing.dates import joined, seconds
from recordings.importing.numerals import find_marks, is_gap, is_number, number, numbers
from recordings.importing.table import Table
from recordings.importing.units import is_none, parse, split_header
from recordings.limits import check_columns, check_lines
from recordings.recording import Floats

_SAMPLE_LINES = 400
"""Number of lines from which delimiter and header are found."""
_COMMENTS = ("#", "%", "//", "!", "'")
_DELIMITERS = (";", "\t", ",", "|", " ")
_ENCODINGS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}
_END_MARKS = ("EOF", "END")


@dataclass(frozen=True)
class TextLayout:
    """How the lines of a text table become cells."""

    delimiter: str
    """A blank stands for any number of blanks."""
    names: tuple[str, ...]
    first: int
    """Index of the first line with data, counted from 0."""
    units: dict[str, str] = field(default_factory=dict)
    """Units by name as the file has them, from brackets or a line of units."""
    marks: str = ""
    """Decimal mark, and the thousands separator behind it; "" where the cells say them."""


def read(path: Path) -> Table:
    """Read a table in text of any make.

    Raises:
        BadInput: it is none, or its rows or numbers can be read in more than one way.
    """
    lines = lines_of(decode(path.read_bytes(), path))
    while lines and (not lines[-1].strip() or lines[-1].strip() in _END_MARKS):
        lines.pop()
    return table_of_lines(path, lines, find_layout(path, lines))


def decode(content: bytes, where: Path) -> str:
    """Decode UTF-8, UTF-16 with its mark, or, where neither fits, Windows-1252.

    Raises:
        BadInput: it is no text.
    """
    encoding = next((name for mark, name in _ENCODINGS.items() if content.startswith(mark)), "utf-8")
    try:
        if b"\0" in content[:4096] and encoding != "utf-16":
            raise UnicodeError
        return content.decode(encoding)
    except UnicodeError:
        if encoding == "utf-8" and b"\0" not in content[:4096]:
            return content.decode("cp1252", "replace")
    raise BadInput(
        f"{where}: a table in text (UTF-8) or a known binary format expected, neither found; export as CSV"
    )


def lines_of(text: str) -> list[str]:
    """Lines of a text; `str.splitlines` would also split at rare characters that may stand in names."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def find_layout(path: Path, lines: list[str]) -> TextLayout:
    """Find the layout of a table in text.

    Raises:
        BadInput: the file is empty, holds no rows of numbers, or names another number of columns than it has.
    """
    sample = lines[:_SAMPLE_LINES]
    check_lines(sample, str(path))
    rows = [line for line in sample if line.strip() and not _is_comment(line)]
    if not rows:
        raise BadInput(
            f"{path}, line 1: a header row with the names of the columns expected, none found; export it again"
        )
    delimiter = _delimiter(rows)
    cells = [_split(line, delimiter) for line in rows]
    width = _width(cells)
    check_columns(width, str(path))
    counts = [_count_numbers(line, delimiter, width) for line in sample]
    # A header may hold a number or two, and a row of data a text or a date.
    typical = float(np.median([count for count in counts[len(counts) // 2 :] if count] or [0]))
    first = next((k for k, count in enumerate(counts) if count and count >= typical / 2), len(sample))
    # Rows of gaps may come first, below a header.
    while first > 1 and counts[first - 1] and _holds_gaps(sample[first - 1], delimiter) and sample[first - 2].strip():
        first -= 1
    bare_end = all(not row[-1] for row in cells if len(row) == width)
    header, units = _header(path, sample[:first], delimiter, width - 1 if bare_end else width, width)
    if not header:
        if first == len(sample):
            raise BadInput(
                f"{path}, line 1: a header row and rows of numbers expected, {rows[0][:40]!r} found; export as CSV"
            )
        return TextLayout(delimiter, tuple(f"#{k + 1}" for k in range(width)), first)
    names, stated = _names(header)
    stated |= {name: unit for name, unit in zip(names, units, strict=False) if not is_none(unit)}
    return TextLayout(delimiter, names, min(first, len(lines)), stated)


def _delimiter(rows: list[str]) -> str:
    """The delimiter that turns the most rows into rows of numbers."""

    def score(delimiter: str) -> tuple[float, int, int, int]:
        table = [_split(line, delimiter) for line in rows]
        width = _width(table)
        regular = [row for row in table if len(row) == width]
        numeric = sum(is_number(cell) for row in regular for cell in row) if width > 1 else 0
        return numeric / (width * len(table)), len(regular), width, -_DELIMITERS.index(delimiter)

    return max(_DELIMITERS, key=score)


def _is_comment(line: str) -> bool:
    """Whether a line holds nothing but a comment."""
    return line.lstrip(' "').startswith(_COMMENTS)


def _split(line: str, delimiter: str) -> list[str]:
    """Cells of a line, without the blanks around them."""
    if '"' in line:
        cells = next(csv.reader([line.strip(" ")], delimiter=delimiter, skipinitialspace=True))
        return [cell.strip() for cell in cells]
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def _width(table: list[list[str]]) -> int:
    """Number of cells that rows have most often, the larger of two equally frequent ones."""
    lengths = [len(row) for row in table]
    return max(set(lengths), key=lambda length: (lengths.count(length), length))


def _count_numbers(line: str, delimiter: str, width: int) -> int:
    """Number of cells with numbers in a line of `width` cells, 0 in other lines."""
    if not line.strip() or _is_comment(line):
        return 0
    cells = _split(line, delimiter)
    return sum(is_number(cell) and not is_gap(cell) for cell in cells) if len(cells) == width else 0


def _holds_gaps(line: str, delimiter: str) -> bool:
    """Whether a line holds nothing but numbers and gaps."""
    return all(is_number(cell) or is_gap(cell) for cell in _split(line, delimiter))


def _header(path: Path, lines: list[str], delimiter: str, least: int, width: int) -> tuple[list[str], list[str]]:
    """Cells of the header, empty where there is none, and of the line of units below it.

    least: number of cells that hold numbers, 1 less than `width` where rows end with a delimiter.
    """
    text = [(k, _split(line, delimiter)) for k, line in enumerate(lines) if line.strip() and not _is_comment(line)]
    # The header may be a comment, as numpy.savetxt writes it.
    comments = [_split(line.lstrip("#%!/' "), delimiter) for line in lines if _is_comment(line)]
    fitting = [(k, cells) for k, cells in text if len(cells) == width]
    units = fitting[-1][1] if fitting else []
    if len(text) > 1 and any(map(parse, units)) and all(is_none(unit) or parse(unit) for unit in units):
        text, fitting = text[: text.index(fitting[-1])], fitting[:-1]
    else:
        units = []
    rows = [cells for _, cells in fitting] or [cells for cells in comments if len(cells) == width]
    if not rows and text:
        place, cells = text[-1]
        if len(cells) >= least and not any(cells[width:]):
            rows = [[*cells, ""][:width]]
        elif len(cells) > 1 and not any(map(is_number, filter(None, cells))):
            raise BadInput(_other_width(path, place + 1, width, cells))
    return (rows[-1], units) if rows else ([], [])


def _other_width(path: Path, line: int, width: int, cells: Sequence[str]) -> str:
    return (
        f"{path}, line {line}: names of {width} columns, as the rows below have cells, expected, {len(cells)} found "
        f"({', '.join(cells)[:60]}); quote a name that holds the delimiter, or export with semicolons where numbers "
        "have decimal commas"
    )


def _names(header: list[str]) -> tuple[tuple[str, ...], dict[str, str]]:
    """Distinct names of the columns, and the units in brackets behind them."""
    split = [split_header(cell) for cell in header]
    bare = [name for name, _ in split]
    names: list[str] = []
    units: dict[str, str] = {}
    for place, (cell, (name, unit)) in enumerate(zip(header, split, strict=True), start=1):
        if unit and not parse(unit) and bare.count(name) > 1:
            name, unit = cell, ""  # what tells columns apart belongs to their names: pos (left), pos (right)
        name = name or f"#{place}"
        name = f"{name}#{place}" if name in names else name
        names.append(name)
        if not is_none(unit):
            units[name] = unit
    return tuple(names), units


def table_of_lines(path: Path, lines: Sequence[str], layout: TextLayout) -> Table:
    """Make a table of the lines of a text in this layout.

    Raises:
        BadInput: the number of cells in a line differs from the header, or numbers can be read in two ways.
    """
    rows: list[list[str]] = []
    places: list[int] = []
    width = len(layout.names)
    end = max((k + 1 for k, line in enumerate(lines) if line.strip() and not _is_comment(line)), default=0)
    for place, line in enumerate(lines[layout.first : end], start=layout.first + 1):
        if _is_comment(line):
            continue
        cells = _split(line, layout.delimiter) if line.strip() else []
        if len(cells) != width:
            raise BadInput(
                f"{path}, line {place}: {width} cells as in the header expected, {len(cells)} found; "
                "complete or remove the line"
            )
        rows.append(cells)
        places.append(place)
    texts = dict(zip(layout.names, zip(*rows, strict=True) if rows else [()] * width, strict=True))
    follow = bool(places) and places[-1] - places[0] == len(places) - 1  # else comments stand between them
    table = Table(path, {}, layout.units, first_line=places[0] if follow else None)
    return _filled(table, joined(texts), layout.marks or find_marks(path, texts, places), places)


def _filled(table: Table, texts: dict[str, Sequence[str]], marks: str, places: Sequence[int]) -> Table:
    """The `table` with its columns of numbers, dates and text."""
    columns: dict[str, Floats] = {}
    invalid: dict[str, str] = {}
    labels: dict[str, NDArray[np.str_]] = {}
    units, start = dict(table.units), None
    for name, cells in texts.items():
        if (values := numbers(cells, marks)) is not None:
            columns[name] = values
        elif (dates := seconds(cells)) is not None:
            columns[name], start = dates
            units[name] = "s"
        else:
            row = next(k for k, cell in enumerate(cells) if number(cell, marks) is None)
            labels[name] = np.array(cells)
            invalid[name] = (
                f"{table.path}, line {places[row]}, column {name!r}: a number expected, {cells[row][:40]!r} found; "
                "correct the cell, or leave it empty for a gap"
            )
    return Table(table.path, columns, units, start, invalid, table.first_line, labels)
