"""Numbers as text: decimal marks and thousands separators, decided for a whole file.

Marks are the decimal mark, with the thousands separator behind it where the file has one: "." or ",.".
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats

_GAPS = frozenset(("", "nan", "null", "none", "n/a", "#n/a", "-", "--", "na"))
_INFINITE = ("inf", "infinity")
_NUMBER = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][-+]?\d+)?")
_BLANKS = "'’ \u00a0\u202f"
"""Thousands separators that are nothing else; a point or a comma may be one, too."""
_GROUPED = r"[-+]?[1-9]\d{{0,2}}(?:[{0}]\d{{3}})+(?![\d{0}])"
_ONCE = (
    r"(?m)^[-+]?(?:(?![1-9]\d{{0,2}}[{0}]\d{{3}}$)\d*[{0}]\d*|[1-9]\d{{0,2}}(?:[{1}]\d{{3}})+[{0}]\d*)"
    r"(?:[eEdD][-+]?\d+)?$"
)
"""Cells in which the mark {0}, beside {1}, can only be a decimal mark."""
_OFTEN = r"(?m)^[-+]?[1-9]\d{{0,2}}(?:(?:[{0}]\d{{3}}){{2,}}|(?:[{0}]\d{{3}})+[{1}]\d*)$"
"""Cells in which it can only separate thousands."""
_EITHER = r"(?m)^[-+]?[1-9]\d{{0,2}}[{0}]\d{{3}}$"
_WHOLE = r"(?m)^[-+]?\d{1,3}$"
_OTHER = {",": ".", ".": ","}


def is_number(cell: str) -> bool:
    """Whether a cell may be a number, with whatever marks."""
    return any(number(cell, marks) is not None for marks in (".,", ",."))


def is_gap(cell: str) -> bool:
    """Whether a cell says that there is no number."""
    return cell.lower() in _GAPS


def find_marks(path: Path, texts: Mapping[str, Sequence[str]], places: Sequence[int]) -> str:
    """The decimal mark of all numbers, and the thousands separator behind it, if they have one.

    Raises:
        BadInput: numbers have several decimal marks, or can be read with and without thousands.
    """
    columns = {name: "\n".join(cells) for name, cells in texts.items()}
    decimal = [mark for mark, other in _OTHER.items() if _found(columns, mark, _ONCE.format(mark, other))]
    thousands = [mark for mark, other in _OTHER.items() if _found(columns, mark, _OFTEN.format(mark, other))]
    open_ = {mark: _found(columns, mark, _EITHER.format(mark)) for mark in _OTHER}
    decimal = decimal or [_OTHER[mark] for mark in thousands]
    if len(decimal) == 1 and decimal[0] not in thousands:
        mark = decimal[0]
        return mark + _OTHER[mark] * (_OTHER[mark] in thousands or open_[_OTHER[mark]] is not None)
    # Three digits behind a mark are decimals where all cells of the column have them.
    mixed = [name for name in filter(None, open_.values()) if re.search(_WHOLE, columns[name])]
    if not decimal and not mixed and None in open_.values():
        return "," if open_[","] else "."
    name = mixed[0] if mixed else _found(columns, ",", _ONCE.format(",", ".")) or open_[","] or open_["."]
    row = next(k for k, cell in enumerate(texts[name or ""]) if set(cell) & set(".,"))
    raise BadInput(
        f"{path}, line {places[row]}, column {name!r}: numbers with one decimal mark expected, "
        f"{texts[name or ''][row]!r} found, which may have thousands separators as well; export with a decimal point "
        "and no thousands separators"
    )


def _found(columns: Mapping[str, str], mark: str, pattern: str) -> str | None:
    """The first column with a cell of that `pattern`."""
    return next((name for name, text in columns.items() if mark in text and re.search(pattern, text)), None)


def numbers(cells: Sequence[str], marks: str) -> Floats | None:
    """Numbers (n,) of the cells of a column; None where it holds anything else."""
    plain = _plain(cells, marks)
    if plain is None:
        careful = [number(cell, marks) for cell in cells]
        return None if None in careful else np.array(careful, dtype=float)
    return plain


def _plain(cells: Sequence[str], marks: str) -> Floats | None:
    """Numbers (n,) of cells that Python reads in one go; None where they hold anything else."""
    text = "\n".join(cells)
    if len(marks) > 1 or "_" in text:  # which Python takes in a number
        return None
    if marks == ",":
        text = text.replace(".", "x").replace(",", ".")
    try:
        return np.array([float(cell or "nan") for cell in text.split("\n")[: len(cells)]])
    except ValueError:
        return None


def number(cell: str, marks: str = ".") -> float | None:
    """The number in a cell, NaN for a gap, None for anything else."""
    if is_gap(cell):
        return float("nan")
    separators = _BLANKS + marks[1:]
    text = re.sub(f"[{separators}]", "", cell) if re.match(_GROUPED.format(separators), cell) else cell
    text = text if marks[0] == "." else text.replace(".", "x").replace(marks[0], ".")
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    return float(text) if text.lower().lstrip("+-") in _INFINITE else None
