"""The table that every import format is read into: named columns of numbers, as they stand in the file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats

ROW = "row"
"""Name of the column of row numbers 0, 1, 2, ..., which every table has."""
_MOST_NAMES = 12
"""Number of columns that an error lists."""


@dataclass(frozen=True, eq=False)
class Table:
    """Columns (n,) of numbers by name; NaN marks a gap."""

    path: Path
    columns: Mapping[str, Floats]
    digest: str
    """SHA-256 of the file."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units that the file states, by column."""
    start: str | None = None
    """ISO 8601 time of the first row, where the file says it."""
    invalid: Mapping[str, str] = field(default_factory=dict)
    """Columns that cannot be read as numbers, each with the sentence that says why."""
    first_line: int | None = None
    """Line of the first row in a text file; None for other formats."""
    left_out: tuple[str, ...] = ()
    """Arrays that became no columns, each with the reason."""
    notes: tuple[str, ...] = ()
    """Sentences for the user: what was left out, and how time was read."""
    options: tuple[str, ...] = ()
    """Options of `daq import` that say explicitly which part of the file was read."""

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

    def listed(self) -> str:
        """Names of the columns, for error messages."""
        names = [*self.columns, *self.invalid]
        more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
        why = f" (left out: {'; '.join(self.left_out[:_MOST_NAMES])})" if self.left_out else ""
        return (f"{', '.join(names[:_MOST_NAMES])}{more}" if names else "none") + why

    def location(self, row: int, name: str | None = None) -> str:
        """Position of a row, or of one value, for error messages."""
        place = f"line {row + self.first_line}" if self.first_line is not None else f"row {row + 1}"
        return f"{self.path}, {place}{f', column {name!r}' if name else ''}"


@dataclass(frozen=True)
class BagPart:
    """Part of a file that holds several recordings."""

    topic: str | None = None
    """Topic of a ROS bag; None: the only one that fits."""
    names: tuple[str, ...] = ()
    """Names of the joints, in the order in which they are numbered; empty: all, in the order of the file."""
