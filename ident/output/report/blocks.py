"""Building blocks of the report's sections. Their texts are plain; the page escapes them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import plotly.graph_objects as go
from markupsafe import Markup

from ident.output.tables import ResultTable


@dataclass(frozen=True)
class Text:
    """Paragraphs."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Notes:
    """A list of sentences."""

    lines: tuple[str, ...]


@dataclass(frozen=True)
class Code:
    """Commands to type."""

    lines: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Plot:
    """A figure with its caption."""

    id: str
    figure: go.Figure
    caption: str


@dataclass(frozen=True, eq=False)
class Drawings:
    """Small drawings side by side, which need no script, with their caption."""

    svg: tuple[Markup, ...]
    caption: str


@dataclass(frozen=True, eq=False)
class Fold:
    """Blocks that can be folded away."""

    title: str
    blocks: tuple["ReportBlock", ...]
    open: bool = False


@dataclass(frozen=True, eq=False)
class Card:
    """One finding, in a frame."""

    title: str
    tags: tuple[str, ...]
    blocks: tuple["ReportBlock", ...]


ReportBlock = Text | Notes | Code | ResultTable | Plot | Drawings | Fold | Card


@dataclass(frozen=True, eq=False)
class ReportSection:
    """A part of the report with a heading."""

    id: str
    title: str
    blocks: tuple[ReportBlock, ...]


def plots(blocks: Sequence[ReportBlock]) -> Iterator[Plot]:
    """Yield all figures of `blocks`, also nested ones, in their order."""
    for block in blocks:
        if isinstance(block, Plot):
            yield block
        elif isinstance(block, Fold | Card):
            yield from plots(block.blocks)
