"""Topics of the page and their changes."""

from collections import Counter
from typing import Literal

Topic = Literal[
    "folder",
    "job",
    "recording",
    "step_list",
    "series",
    "candidates",
    "previews",
    "residuals",
    "diagnosis",
    "swarm_progress",
    "swarm_result",
    "saved",
    "use",
    "tab",
    "run",
    "fleet",
    "message",
]


class Changes:
    """Counts the changes of each topic; the pages that show a topic redraw when its count has changed."""

    def __init__(self) -> None:
        self._counts: Counter[Topic] = Counter()

    def mark(self, *topics: Topic) -> None:
        """Mark `topics` as changed."""
        self._counts.update(topics)

    def count(self, topics: tuple[Topic, ...]) -> int:
        """Return the number of changes of `topics` so far."""
        return sum(self._counts[topic] for topic in topics)
