"""Reader of numeric CSV files: parses large blocks at once; errors name the line and the column."""

import csv
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import BinaryIO

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats

_BLOCK = 1 << 24
"""Number of bytes that are parsed at a time."""


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


def read_table(path: Path, block_size: int = _BLOCK) -> CsvTable:
    """Read a comma-separated file with a header row, `block_size` bytes at a time.

    Another thread can run between two blocks.

    Raises:
        BadInput: the file is missing or unreadable, a column name is empty or a duplicate, the number of cells in a
            line differs from the header, or a cell is not a finite number, empty or NaN.
    """
    digest = hashlib.sha256()
    try:
        with path.open("rb") as stream:
            header = stream.readline()
            digest.update(header)
            names = _names(path, header)
            arrays, line = [np.empty((0, len(names)))], 2
            for block in _blocks(stream, block_size):
                digest.update(block)
                arrays.append(_parse(path, block, names, line))
                line += len(arrays[-1])
    except FileNotFoundError:
        raise BadInput(f"{path} does not exist; check the path") from None
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}") from None
    table = CsvTable(path, dict(zip(names, np.concatenate(arrays).T.copy(), strict=True)), digest.hexdigest())
    for name, column in table.columns.items():
        if np.isinf(column).any():
            location = table.location(int(np.argmax(np.isinf(column))), name)
            raise BadInput(f"{location}: a finite number expected, infinity found; leave the cell empty for a gap")
    return table


def _names(path: Path, header: bytes) -> list[str]:
    try:
        text = header.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise BadInput(f"{path}, line 1: text in UTF-8 expected; save the file as UTF-8 CSV") from None
    if not text:
        raise BadInput(f"{path}, line 1: a header row with the names of the columns expected, none found")
    names = [name.strip() for name in next(csv.reader([text]))]
    if len(names) == 1 and (";" in text or "\t" in text):
        raise BadInput(f"{path}, line 1: commas between columns expected, {text[:40]!r} found; convert the file")
    for name in names:
        if not name or names.count(name) > 1:
            problem = f"{name!r} twice" if name else "an empty one"
            raise BadInput(f"{path}, line 1: every column needs a name of its own, {problem} found")
    return names


def _blocks(stream: BinaryIO, size: int) -> Iterator[bytes]:
    """Read the rest of the file in blocks of whole lines."""
    while block := stream.read(size):
        yield block if block.endswith(b"\n") else block + stream.readline()


def _parse(path: Path, block: bytes, names: list[str], line: int) -> Floats:
    """Parse the numbers (n, k) of a block that begins at `line`."""
    cells = block.translate(None, b"\r \t").rstrip(b"\n") + b"\n"
    text = cells.decode("utf-8", "replace")
    if text == "\n":
        return np.empty((0, len(names)))
    if _has_empty_cell(cells):
        if "\n\n" in text or text.startswith("\n"):
            _raise_first_invalid_line(path, text, names, line)
        text = _with_gaps(text)
    try:
        numbers = np.loadtxt(StringIO(text), delimiter=",", comments=None, ndmin=2)
        if numbers.shape[1] == len(names):
            return numbers
    except ValueError:
        pass
    _raise_first_invalid_line(path, text, names, line)
    raise BadInput(f"{path}, behind line {line}: numbers expected; check the file")


def _has_empty_cell(cells: bytes) -> bool:
    """Whether two separators follow each other, or one is the first character."""
    characters = np.frombuffer(b"\n" + cells, np.uint8)
    separates = (characters == ord(",")) | (characters == ord("\n"))
    return bool((separates[1:] & separates[:-1]).any())


def _with_gaps(text: str) -> str:
    """Write nan into empty cells."""
    text = text.replace("\n,", "\nnan,").replace(",\n", ",nan\n")
    text = f"nan{text}" if text.startswith(",") else text
    # Twice: neighbouring empty cells share a comma.
    return text.replace(",,", ",nan,").replace(",,", ",nan,")


def _raise_first_invalid_line(path: Path, text: str, names: list[str], line: int) -> None:
    for number, content in enumerate(text.rstrip("\n").split("\n"), start=line):
        cells = content.split(",") if content else []
        if len(cells) != len(names):
            raise BadInput(f"{path}, line {number}: {len(names)} cells as in the header expected, {len(cells)} found")
        for name, cell in zip(names, cells, strict=True):
            if not _is_number(cell):
                raise BadInput(f"{path}, line {number}, column {name!r}: a number expected, {cell[:40]!r} found")


def _is_number(cell: str) -> bool:
    try:
        np.loadtxt(StringIO(cell or "nan"), comments=None)
    except ValueError:
        return False
    return True
