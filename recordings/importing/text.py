"""Layout of a text table, found from its first lines: delimiter, decimal mark, comments, header, units."""

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.importing.units import parse, split_header
from recordings.limits import check_columns, check_lines

_SAMPLE_LINES = 400
"""Number of lines from which the layout is found."""
_COMMENTS = ("#", "%", "//", "!", "'")
_DELIMITERS = (";", "\t", ",", "|", " ")
_GAPS = frozenset(("", "nan", "null", "none", "n/a", "#n/a", "-", "--", "na"))
_NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][-+]?\d+)?")
_ENCODINGS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"\xef\xbb\xbf": "utf-8-sig"}


@dataclass(frozen=True)
class TextLayout:
    """How the lines of a text table become cells."""

    delimiter: str
    """A blank stands for any number of blanks."""
    decimal: str
    names: tuple[str, ...]
    units: dict[str, str]
    """Units by name, from brackets or a line of units."""
    first: int
    """Index of the first line with data, counted from 0."""


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


def is_comment(line: str) -> bool:
    """Whether a line holds nothing but a comment."""
    return line.lstrip(' "').startswith(_COMMENTS)


def split(line: str, delimiter: str) -> list[str]:
    """Cells of a line, without the blanks around them."""
    if '"' in line:
        cells = next(csv.reader([line.strip(" ")], delimiter=delimiter, skipinitialspace=True))
        return [cell.strip() for cell in cells]
    if delimiter == " ":
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def number(cell: str, decimal: str) -> float | None:
    """The number in a cell, NaN for a gap, None for anything else."""
    if cell.lower() in _GAPS:
        return float("nan")
    text = cell if decimal == "." else cell.replace(".", "x").replace(decimal, ".")
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    return float(text) if text.lower().lstrip("+-") in ("inf", "infinity") else None


def find_layout(path: Path, lines: list[str]) -> TextLayout:
    """Find the layout of a table in text.

    Raises:
        BadInput: the file is empty, or holds no rows of numbers.
    """
    sample = lines[:_SAMPLE_LINES]
    check_lines(sample, str(path))
    rows = [line for line in sample if line.strip() and not is_comment(line)]
    if not rows:
        raise BadInput(
            f"{path}, line 1: a header row with the names of the columns expected, none found; export it again"
        )
    delimiter, decimal = _separators(rows)
    width = _width([split(line, delimiter) for line in rows])
    check_columns(width, str(path))
    counts = [_count_numbers(line, delimiter, decimal, width) for line in sample]
    # A header may hold a number or two, and a row of data a text or a date.
    typical = float(np.median([count for count in counts[len(counts) // 2 :] if count] or [0]))
    first = next((k for k, count in enumerate(counts) if count and count >= typical / 2), len(sample))
    header, units = _header(sample[:first], delimiter, width)
    if header is None:
        if first == len(sample):
            raise BadInput(
                f"{path}, line 1: a header row and rows of numbers expected, {rows[0][:40]!r} found; export as CSV"
            )
        return TextLayout(delimiter, decimal, tuple(f"#{k + 1}" for k in range(width)), {}, first)
    names, stated = _names(path, header)
    stated |= {name: unit for name, unit in zip(names, units, strict=False) if parse(unit)}
    return TextLayout(delimiter, decimal, names, stated, min(first, len(lines)))


def _separators(rows: list[str]) -> tuple[str, str]:
    """Delimiter and decimal mark that turn the most rows into rows of numbers."""

    def score(pair: tuple[str, str]) -> tuple[float, int, int]:
        table = [split(line, pair[0]) for line in rows]
        width = _width(table)
        if width < 2:
            return 0.0, 0, 0
        cells = [cell for row in table if len(row) == width for cell in row]
        numeric = sum(number(cell, pair[1]) is not None for cell in cells) / len(cells)
        regular = sum(len(row) == width for row in table) / len(table)
        return numeric * regular, width, -_DELIMITERS.index(pair[0])

    quoted = any('"' in row for row in rows)  # a cell may then hold the delimiter
    return max(((d, mark) for d in _DELIMITERS for mark in ".," if d != mark or quoted), key=score)


def _width(table: list[list[str]]) -> int:
    """Number of cells that rows have most often, the larger of two equally frequent ones."""
    lengths = [len(row) for row in table]
    return max(set(lengths), key=lambda length: (lengths.count(length), length))


def _count_numbers(line: str, delimiter: str, decimal: str, width: int) -> int:
    """Number of cells with numbers in a line of `width` cells, 0 in other lines."""
    if not line.strip() or is_comment(line):
        return 0
    cells = split(line, delimiter)
    return sum(cell != "" and number(cell, decimal) is not None for cell in cells) if len(cells) == width else 0


def _header(lines: list[str], delimiter: str, width: int) -> tuple[list[str] | None, list[str]]:
    """Cells of the header, None where there is none, and of the line of units below it."""
    text = [split(line, delimiter) for line in lines if line.strip() and not is_comment(line)]
    # The header may be a comment, as numpy.savetxt writes it.
    comments = [split(line.lstrip("#%!/' "), delimiter) for line in lines if is_comment(line)]
    rows = [cells for cells in text if len(cells) == width] or [cells for cells in comments if len(cells) == width]
    if not rows and text and abs(len(text[-1]) - width) == 1 and width > 2:
        # A delimiter at the end of the lines with numbers, or of the header, only.
        rows = [[*text[-1], ""][:width]]
    if not rows:
        return None, []
    bare = [cell.strip("[]() ") for cell in rows[-1]]
    if len(rows) > 1 and any(bare) and all(not unit or parse(unit) or unit == "-" for unit in bare):
        return rows[-2], bare
    return rows[-1], []


def _names(path: Path, header: list[str]) -> tuple[tuple[str, ...], dict[str, str]]:
    """Distinct names of the columns, and the units in brackets behind them."""
    names: list[str] = []
    units: dict[str, str] = {}
    for place, cell in enumerate(header, start=1):
        name, unit = split_header(cell)
        name = name or f"#{place}"
        if name in names:
            name = f"{name}#{place}"
        names.append(name)
        if unit:
            units[name] = unit
    return tuple(names), units
