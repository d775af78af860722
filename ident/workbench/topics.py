"""Topics of the page and their changes."""

from collections import Counter
from collections.abc import Callable
from typing import Literal

Topic = Literal[
    "folder",
    "job",
    "recording",
    "steps",
    "series",
    "candidates",
    "previews",
    "residuals",
    "advice",
    "diagnosis",
    "saved",
    "printed",
    "tab",
    "run",
    "fleet",
    "project",
    "message",
]


class Changes:
    """Counts the changes of each topic; the pages that show a topic redraw when its count has changed."""

    def __init__(self) -> None:
        self._counts: Counter[Topic] = Counter()
        self.on_mark: Callable[[set[Topic]], None] = lambda topics: None
        """Called with topics that have changed, by the thread that has changed them."""

    def mark(self, *topics: Topic) -> None:
        """Mark `topics` as changed."""
        self._counts.update(topics)
        self.on_mark(set(topics))

    def count(self, topics: tuple[Topic, ...]) -> int:
        """Return the number of changes of `topics` so far."""
        return sum(self._counts[topic] for topic in topics)
