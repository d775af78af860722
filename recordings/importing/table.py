"""The table that every import format is read into: named columns of numbers, as they stand in the file."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.recording import Floats, Ints

JOINT_QUANTITIES = ("position", "velocity", "command", "voltage", "effort", "current", "temperature")
"""What a column may hold of a joint: QUANTITY_1 of the first."""
ROW = "row"
"""Name of the column of row numbers 0, 1, 2, ..., which every table has."""
_TOKEN = re.compile(r"[A-Z]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöü]+|\d+")
_MOST_NAMES = 12
"""Number of columns that an error lists."""
_LONGEST_NAME = 60
"""Of a column in an error [characters]: what is no table has names of any length."""


def words_of(name: str) -> list[str]:
    """Words and numbers of the name of a column, in small letters."""
    return [word.lower() for word in _TOKEN.findall(name)]


def distinct(names: Sequence[str]) -> list[str]:
    """The `names`, each once: to one that stood before, its place is added."""
    return [name if names.index(name) == k else f"{name}#{k + 1}" for k, name in enumerate(names)]


@dataclass(frozen=True, eq=False)
class Table:
    """Columns (n,) of numbers by name; NaN marks a gap."""

    path: Path
    columns: Mapping[str, Floats]
    units: Mapping[str, str] = field(default_factory=dict)
    """Units that the file states, by column."""
    start: str | None = None
    """ISO 8601 time of the first row, where the file says it."""
    invalid: Mapping[str, str] = field(default_factory=dict)
    """Columns that cannot be read as numbers, each with the sentence that says why."""
    first_line: int | None = None
    """Line of the first row in a text file; None for other formats."""
    labels: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """Cells (n,) of columns of text, which are `invalid` as well."""
    left_out: tuple[str, ...] = ()
    """Arrays that became no columns, each with the reason."""
    notes: tuple[str, ...] = ()
    """Sentences for the user: what was left out, and how time was read."""
    options: tuple[str, ...] = ()
    """Options of `daq import` that say explicitly which part of the file was read."""
    digest: str = ""
    """SHA-256 of the file."""

    @property
    def count(self) -> int:
        """Number of rows n."""
        return max((len(column) for column in self.columns.values()), default=0)

    def column(self, name: str) -> Floats:
        """Values (n,) of a column, finite or NaN.

        Raises:
            BadInput: there is no such column, or it holds text or infinity.
        """
        if name in self.invalid:
            raise BadInput(self.invalid[name])
        if name not in self.columns:
            if name == ROW:
                return np.arange(self.count, dtype=float)
            similar = get_close_matches(name, [*self.columns, *self.invalid], n=1)
            hint = f"did you mean '{similar[0]}'?" if similar else "correct the name"
            raise BadInput(f"{self.path}: a column '{name}' expected, {self.listed()} found; {hint}")
        values = self.columns[name]
        if np.isinf(values).any():
            where = self.location(int(np.argmax(np.isinf(values))), name)
            raise BadInput(f"{where}: a finite number expected, infinity found; leave the cell empty for a gap")
        return values

    @property
    def unreadable(self) -> list[str]:
        """Columns that hold text or infinity."""
        return [*self.invalid, *(name for name, values in self.columns.items() if np.isinf(values).any())]

    def of_joints(self, names: Sequence[str]) -> "Table":
        """The table with the joints of these `names` only: column QUANTITY_NAME becomes QUANTITY_1 for the first.

        Raises:
            BadInput: a name is that of no joint.
        """
        if not names:
            return self
        of = {column: column.partition("_") for column in (*self.columns, *self.invalid)}
        known = dict.fromkeys(name for head, _, name in of.values() if head in JOINT_QUANTITIES and name)
        if unknown := [name for name in names if name not in known]:
            listed = ", ".join(known) or "no column such as position_1"
            raise BadInput(f"{self.path}: --names: joints ({listed}) expected, {unknown[0]!r} found; correct it")
        numbers = {name: f"{number}" for number, name in enumerate(names, start=1)}
        kept = {
            column: column if name not in known else f"{head}_{numbers[name]}"
            for column, (head, _, name) in of.items()
            if name not in known or name in numbers
        }

        def renamed(values: Mapping[str, Any]) -> dict[str, Any]:
            return {kept[column]: value for column, value in values.items() if column in kept}

        note = "joints: " + ", ".join(f"{number} = {name}" for name, number in numbers.items())
        return replace(
            self,
            columns=renamed(self.columns),
            units=renamed(self.units),
            invalid=renamed(self.invalid),
            labels={},
            notes=(*self.notes, note),
            options=(*self.options, "--names", ",".join(names)),
        )

    def of_rows(self, rows: Ints) -> "Table":
        """The table with these rows (m,) only."""
        columns = {name: values[rows] for name, values in self.columns.items()}
        follow = self.first_line is not None and (np.diff(rows) == 1).all()
        line = self.first_line + int(rows[0]) if follow and self.first_line is not None else None
        labels = {name: cells[rows] for name, cells in self.labels.items()}
        return replace(self, columns=columns, labels=labels, first_line=line)

    def listed(self) -> str:
        """Names of the columns, for error messages."""
        names = [*self.columns, *self.invalid]
        more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
        why = f" (left out: {'; '.join(self.left_out[:_MOST_NAMES])})" if self.left_out else ""
        shown = ", ".join(name[:_LONGEST_NAME] for name in names[:_MOST_NAMES])
        return (f"{shown}{more}" if names else "none") + why

    def location(self, row: int, name: str | None = None) -> str:
        """Position of a row, or of one value, for error messages."""
        place = f"line {row + self.first_line}" if self.first_line is not None else f"row {row + 1}"
        return f"{self.path}, {place}{f', column {name!r}' if name else ''}"
