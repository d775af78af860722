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
    "candidates",
    "previews",
    "residuals",
    "diagnosis",
    "swarm_progress",
    "swarm_result",
    "run",
    "message",
]
TOPIC_OF_VIEW: dict[type, Topic] = {
    views.RecordingView: "recording",
    views.CandidateList: "candidates",
    views.CandidatePreviews: "previews",
    views.ResidualView: "residuals",
    views.DiagnosisView: "diagnosis",
    views.SwarmProgress: "swarm_progress",
    views.SwarmResult: "swarm_result",
}
"""Topic, and attribute of the session, under which each view of the worker is stored."""
LADDER_TOPICS: tuple[Topic, ...] = ("ladder", "series", "candidates", "previews", "residuals")
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
