"""Progress of a command on its terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ident.estimation.problem import Progress


@contextmanager
def progress_bar(first: str, then: str) -> Iterator[Progress]:
    """A bar on stderr, if that is a terminal: called `first` until it is told of a step, `then` from there on."""
    from rich.console import Console
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    with Bar(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(first, total=None)
        yield lambda done, total, *_: bar.update(task, description=then, completed=done, total=total)


@contextmanager
def spinner() -> Iterator[Callable[[str], None]]:
    """What is being done, on stderr, if that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda what: None
        return
    with console.status("reading") as status:
        yield lambda what: status.update(what)
