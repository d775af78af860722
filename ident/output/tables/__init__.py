"""Tables of results: one description of each, which console, report and page show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ResultTable:
    """A table of formatted cells."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    words: Sequence[int] = (0,)
    """Columns of text; the others hold numbers and are aligned to the right."""
    title: str = ""
    """Of the table on the console; report and page have headings of their own."""
    sections: Sequence[int] = ()
    """Rows, from 0, below which the console draws a line."""
    styles: Mapping[int, str] = field(default_factory=dict)
    """Colours of rows on the console."""


def per_joint(first: str, dof: int, *others: str) -> tuple[str, ...]:
    """Return a head with one column for each joint between the `first` and the `others`."""
    return (first, *(f"joint {number}" for number in range(1, dof + 1)), *others)
