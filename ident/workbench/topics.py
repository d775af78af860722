"""Topics of a session whose changes the page follows, and the current job of the worker."""

import time
from dataclasses import dataclass
from typing import Literal

from ident.workbench import views

Topic = Literal[
    "folder",
    "job",
    "recording",
    "ladder",
    "series",
    "choice",
    "signatures",
    "failing",
    "answer",
    "descent",
    "swarmed",
    "run",
    "message",
]
TOPIC_OF_VIEW: dict[type, Topic] = {
    views.RecordingView: "recording",
    views.CandidateList: "choice",
    views.CandidatePreviews: "signatures",
    views.ResidualView: "failing",
    views.DiagnosisView: "answer",
    views.SwarmProgress: "descent",
    views.SwarmResult: "swarmed",
}
"""Topic, and attribute of the session, under which each view of the worker is stored."""
LADDER_TOPICS: tuple[Topic, ...] = ("ladder", "series", "choice", "signatures", "failing")
"""Topics that change with the ladder."""


@dataclass(frozen=True)
class Job:
    """The job that the worker executes."""

    text: str
    start_time: float
    blocking: bool
    """Whether no other job can be started before it ends."""
    paused_at: float | None = None
    """Monotonic time of the pause [s]; None while it runs."""

    @property
    def seconds(self) -> float:
        """Return the time taken so far without pauses [s]."""
        return (self.paused_at or time.monotonic()) - self.start_time
