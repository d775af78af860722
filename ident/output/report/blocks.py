"""What a section of the report is made of. Texts are plain: the page escapes them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import plotly.graph_objects as go


@dataclass(frozen=True)
class Text:
    """Paragraphs."""

    kind: ClassVar[str] = "text"
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Notes:
    """A list of sentences."""

    kind: ClassVar[str] = "notes"
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Code:
    """Lines to be typed."""

    kind: ClassVar[str] = "code"
    lines: tuple[str, ...]


@dataclass(frozen=True)
class ReportTable:
    """Cells as they are shown."""

    kind: ClassVar[str] = "table"
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    words: tuple[int, ...] = (0,)
    """Columns that hold words; those of numbers are aligned to the right."""


@dataclass(frozen=True, eq=False)
class Plot:
    """A figure with what it shows."""

    kind: ClassVar[str] = "plot"
    id: str
    figure: go.Figure
    caption: str


@dataclass(frozen=True, eq=False)
class Fold:
    """Blocks that can be folded away."""

    kind: ClassVar[str] = "fold"
    title: str
    blocks: tuple["ReportBlock", ...]
    open: bool = False


@dataclass(frozen=True, eq=False)
class Card:
    """Something that was found."""

    kind: ClassVar[str] = "card"
    title: str
    tags: tuple[str, ...]
    blocks: tuple["ReportBlock", ...]


ReportBlock = Text | Notes | Code | ReportTable | Plot | Fold | Card


@dataclass(frozen=True, eq=False)
class ReportSection:
    """A part of the report with a heading."""

    id: str
    title: str
    blocks: tuple[ReportBlock, ...]


def plots(blocks: Sequence[ReportBlock]) -> Iterator[Plot]:
    """All figures, in their order."""
    for block in blocks:
        if isinstance(block, Plot):
            yield block
        elif isinstance(block, Fold | Card):
            yield from plots(block.blocks)
