"""Show the progress of a command on its terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ident.estimation.problem import Progress


@contextmanager
def progress_bar(first: str, then: str) -> Iterator[Progress]:
    """Show a bar on stderr if that is a terminal, labelled `first` until the first step is done, then `then`."""
    from rich.console import Console
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    with Bar(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(first, total=None)
        yield lambda done, total, *_: bar.update(task, description=then, completed=done, total=total)


@contextmanager
def spinner() -> Iterator[Callable[[str], None]]:
    """Show the current activity on stderr if that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda activity: None
        return
    with console.status("reading") as status:
        yield lambda activity: status.update(activity)
