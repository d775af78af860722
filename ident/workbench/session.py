"""What the user is doing: one session, seen by every tab that shows the page, and found again after a reload."""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ident import effects
from ident.workbench import views
from ident.workbench.folder import Folder
from ident.workbench.recorder import Recorder
from ident.workbench.work import Work
from recordings.errors import BadInput

UNATTENDED = 20.0
"""So long no browser may show the page while drives move: time to load it again [s]."""

Part = Literal["folder", "job", "recording", "ladder", "series", "choice", "failing", "answer", "run", "message"]


@dataclass(frozen=True)
class Job:
    """What the working process does."""

    what: str
    began: float
    urgent: bool
    """Somebody waits for it: nothing else can be asked for meanwhile."""


class Session:
    """The state behind the page. `versions` tells which part has changed since it was drawn."""

    def __init__(self, folder: Folder, effect_files: Sequence[Path] = ()) -> None:
        self.folder = folder
        self.library = effects.library(effect_files)
        self.versions: Counter[Part] = Counter()
        self.train: str | None = None
        self.validate: str | None = None
        self.tab = "data"
        self.joint = 0
        self.dark = False
        self.wanted: tuple[float, float] | None = None
        """Part of a recording that is to be shown next [s]."""
        self.job: Job | None = None
        self.message = ""
        self.recording: views.RecordingView | None = None
        self.ladder: views.LadderView | None = None
        self.series: tuple[views.Series, ...] = ()
        self.choice: views.Choice | None = None
        self.failing: views.Failing | None = None
        self.answer: views.Answer | None = None
        self.saved: tuple[str, views.Failing] | None = None
        """The model that was saved last, and where."""
        self._seen = 0.0
        self.recorder = Recorder(
            folder.root, lambda: self.changed("run"), lambda: self.changed("run", "folder"), self._attended
        )
        self._work = Work(self._said, effect_files)
        self._asked = 0
        """Tasks that the working process has not finished."""
        self._lost = False
        """Whether a new working process has to be told of the ladder first."""

    def changed(self, *parts: Part) -> None:
        """Whoever shows one of `parts` shall draw it again."""
        self.versions.update(parts)

    def seen(self) -> None:
        """A browser shows the page now."""
        self._seen = time.monotonic()

    def _attended(self) -> bool:
        return time.monotonic() - self._seen < UNATTENDED

    def prepare(self) -> None:
        """Get ready for the first click."""
        self._work.prepare()

    def close(self) -> None:
        """Stop what runs."""
        self.recorder.close()
        self._work.cancel()

    # Recordings

    def choose(self, train: str | None, validate: str | None) -> None:
        """The recordings to work with; what was found from others goes."""
        for name in (train, validate):
            if name is not None:
                self.folder.path(name)
        if train is not None and train == validate:
            raise BadInput(
                "another recording expected for validation: on the training data every model looks better than it is"
            )
        self.train, self.validate = train, validate
        if self.job:
            self._stop_work()
        self.recording = self.ladder = self.choice = self.failing = self.answer = None
        self.series = ()
        self.changed("folder", "job", "recording", "ladder", "series", "choice", "failing", "answer")
        if train is not None:
            self.look(train)

    def look(self, name: str) -> None:
        """Show a recording as it is."""
        path = self.folder.path(name)
        self._begin("reading", urgent=False)
        self._send("look", path)

    # The mission

    def fit(self) -> None:
        """The base model."""
        self._ask("fit", *self._files())

    def add(self, name: str) -> None:
        """One effect more."""
        self._ask("add", name)

    def remove(self, index: int) -> None:
        """One effect less."""
        self._ask("remove", index)

    def undo(self) -> None:
        """As it was before the last change."""
        self._ask("undo")

    def diagnose(self) -> None:
        """Let the full diagnosis find all that is missing."""
        self._ask("diagnose")

    def cancel(self) -> None:
        """End what is being computed; what was found before stays."""
        self._stop_work()
        self._say("Cancelled; nothing has changed.")
        self.changed("job")

    def _files(self) -> tuple[Path, Path | None]:
        if self.train is None:
            raise BadInput("a recording to fit expected, none chosen; choose one of the list")
        return self.folder.path(self.train), self.folder.path(self.validate) if self.validate else None

    def _ask(self, task: str, *arguments: Any) -> None:
        if self.job and self.job.urgent:
            raise BadInput(f"one thing at a time: {self.job.what} is going on; wait for it, or cancel it")
        self._begin(task, urgent=True)
        if self._lost and self.ladder and task != "fit":
            kept = [(rung.label, rung.terms, rung.x) for rung in self.ladder.rungs]
            self._send("restore", *self._files(), kept)
        self._lost = False
        self._send(task, *arguments)

    def _send(self, task: str, *arguments: Any) -> None:
        self._asked += 1
        self._work.ask(task, *arguments)

    def _stop_work(self) -> None:
        self._work.cancel()
        self._asked, self.job, self._lost = 0, None, True

    def _begin(self, what: str, urgent: bool) -> None:
        self.message = ""
        self.job = Job(what, time.monotonic(), urgent)
        self.changed("job", "message")

    # What the working process says

    def _said(self, kind: str, value: Any) -> None:
        if kind == "progress" and self.job:
            self.job = Job(value, self.job.began, self.job.urgent)
        elif kind == "shown":
            self._shown(value)
        elif kind in ("idle", "failed"):
            self._asked -= 1
            if self._asked <= 0:
                self._asked, self.job = 0, None
            self._lost = self._lost or self._work.fresh
            if kind == "failed":
                self._say(value)
        self.changed("job")

    def _shown(self, value: Any) -> None:
        if isinstance(value, views.RecordingView):
            self.recording = value
            self.changed("recording")
        elif isinstance(value, views.LadderView):
            self.ladder, self.choice, self.failing = value, None, None
            self.changed("ladder", "choice", "failing")
        elif isinstance(value, tuple):
            self.series = value
            if self.job:
                self.job = Job(self.job.what, self.job.began, urgent=False)
            self.changed("series")
        elif isinstance(value, views.Choice):
            self.choice = value
            self.changed("choice")
        elif isinstance(value, views.Failing):
            self.failing = value
            self.changed("failing")
        elif isinstance(value, views.Answer):
            self.answer = value
            self.changed("answer")

    def _say(self, text: str) -> None:
        self.message = text
        self.changed("message")
