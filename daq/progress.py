"""Progress bar for tasks other than a run of the drives."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Show = Callable[[int, int | None, str], None]
"""Callback for the amount done, the total (None if unknown) and a short text; may be called at any rate."""

_INTERVAL = 0.1
"""Shortest time between two updates [s]."""


@contextmanager
def progress_bar(description: str) -> Iterator[Show]:
    """Show a progress bar on stderr if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, words: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[words]}"), TimeElapsedColumn())
    with Progress(*columns, console=console, auto_refresh=False, transient=True) as bar:
        task = bar.add_task(description, total=None, words="")
        last = 0.0

        def show(done: int, total: int | None, words: str) -> None:
            nonlocal last
            if time.monotonic() - last > _INTERVAL:
                last = time.monotonic()
                bar.update(task, completed=done, total=total, words=words)
                bar.refresh()

        yield show
