"""Progress of a command on its terminal."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class Show(Protocol):
    """Callback that shows an activity and how much of it is done; cheap enough to be called at any rate."""

    def __call__(self, activity: str, done: int = 0, total: int | None = None, /) -> None:
        """Show `activity`, of which `done` of `total` are done; without a total the bar only moves."""


@contextmanager
def progress_bar(activity: str) -> Iterator[Show]:
    """Show the current activity on stderr if that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(activity, total=None)

        def show(activity: str, done: int = 0, total: int | None = None, /) -> None:
            bar.update(task, description=activity, completed=done, total=total)

        yield show
