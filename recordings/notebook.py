"""Tables and progress that a notebook shows."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from html import escape
from time import monotonic
from typing import Any

from recordings.progress import Show

_INTERVAL = 0.2
"""Shortest time between two pictures of the progress [s]: each is a message to the browser."""


def html_table(caption: str, head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Make a table of text, which is escaped: names of files, joints and effects are the user's."""

    def row(cells: Iterable[str], tag: str) -> str:
        return f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"

    body = "".join(row(cells, "td") for cells in rows)
    return f"<table><caption>{escape(caption)}</caption>{row(head, 'th')}{body}</table>"


@contextmanager
def cell_progress() -> Iterator[Show]:
    """Show the current activity below the running cell of a notebook; elsewhere, as in a script, show nothing."""
    handle: Any = None
    due = 0.0

    def put(html: str) -> None:
        nonlocal handle
        from IPython.display import HTML, display

        if handle:
            handle.update(HTML(html))
        else:
            handle = display(HTML(html), display_id=True)

    def show(activity: str, done: int = 0, total: int | None = None, /) -> None:
        nonlocal due
        if monotonic() >= due:
            due = monotonic() + _INTERVAL
            share = f' value="{done}" max="{total}"' if total else ""
            put(f"<progress{share}></progress> {escape(activity)}")

    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    try:
        yield show if hasattr(shell, "kernel") else lambda *_: None
    finally:
        if handle:
            put("")
