"""The parts of a session that a page follows, and the work that is going on for it."""

import time
from dataclasses import dataclass
from typing import Literal

from ident.workbench import views

Part = Literal[
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
SHOWN_AS: dict[type, Part] = {
    views.RecordingView: "recording",
    views.Choice: "choice",
    views.Signatures: "signatures",
    views.Failing: "failing",
    views.Answer: "answer",
    views.Descent: "descent",
    views.Swarmed: "swarmed",
}
"""What the working process hands over, by the part that it is kept as."""
OF_A_LADDER: tuple[Part, ...] = ("ladder", "series", "choice", "signatures", "failing")
"""What changes when the ladder does."""


@dataclass(frozen=True)
class Job:
    """What the working process does."""

    what: str
    began: float
    urgent: bool
    """Somebody waits for it: nothing else can be asked for meanwhile."""
    paused: float | None = None
    """Since when."""

    @property
    def seconds(self) -> float:
        """How long it has taken so far, without pauses [s]."""
        return (self.paused or time.monotonic()) - self.began
