"""What the user is doing: one session, seen by every tab that shows the page, and found again after a reload."""

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ident.dynamics.effects.library import library
from ident.workbench import views
from ident.workbench.branches import Branches
from ident.workbench.cli_equivalent import of_fit
from ident.workbench.folder import Folder
from ident.workbench.recorder import Recorder
from ident.workbench.topics import OF_A_LADDER, SHOWN_AS, Job, Part
from ident.workbench.views import Chosen
from ident.workbench.worker import Work
from recordings.errors import BadInput

UNATTENDED = 20.0
"""So long no browser may show the page while drives move: time to load it again [s]."""


class Session:
    """The state behind the page. `versions` tells which part has changed since it was drawn."""

    def __init__(self, folder: Folder, effect_files: Sequence[Path] = ()) -> None:
        self.folder = folder
        self.library = library(effect_files)
        self.versions: Counter[Part] = Counter()
        self.train: str | None = None
        self.validate: str | None = None
        self.tab = "data"
        self.joint = 0
        self.dark = False
        self.wanted: tuple[str, float, float] | None = None
        """Part of a recording that is to be shown next: its name, from and to [s]."""
        self.job: Job | None = None
        self.message = ""
        self.recording: views.RecordingView | None = None
        self.branches: Branches | None = None
        self.series: tuple[views.Series, ...] = ()
        self.choice: views.Choice | None = None
        self.signatures: views.Signatures | None = None
        self.failing: views.Failing | None = None
        self.answer: views.Answer | None = None
        self.descent: views.Descent | None = None
        """Of the swarm that searches now."""
        self.swarmed: views.Swarmed | None = None
        self.saved: tuple[str, views.Failing] | None = None
        """The model that was saved last, and where."""
        self._seen = 0.0
        self.recorder = Recorder(
            folder.root, lambda: self.changed("run"), lambda: self.changed("run", "folder"), self._attended
        )
        self._work = Work(self._said, effect_files)
        self._asked = 0
        """Tasks that the working process has not finished."""
        self._unfinished = False
        """Whether something else was asked for before all was said of the present ladder."""
        self._then: Callable[[views.LadderView], Branches] = Branches.begun
        """What becomes of the branches when the ladder that was asked for is there."""

    @property
    def ladder(self) -> views.LadderView | None:
        """The present one."""
        return self.branches.present.ladder if self.branches else None

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
        self.recording = self.answer = self.descent = self.swarmed = None
        self._forget()
        self.changed("folder", "job", "recording", "answer", "descent", "swarmed")
        if train is not None:
            self._aside("reading", False, "look", *self._files())

    def _forget(self) -> None:
        self.branches = self.choice = self.signatures = self.failing = None
        self.series = ()
        self.changed(*OF_A_LADDER)

    def look(self, name: str) -> None:
        """Show a recording as it is."""
        path = self.folder.path(name)
        self._refuse_while_paused()
        self._aside("reading", False, "look", path)

    # The mission

    def fit(self) -> None:
        """The base model."""
        self._ask(Branches.begun, "fit", *self._files())

    def add(self, name: str) -> None:
        """One effect more."""
        before = self._present()
        self._ask(before.grown, "add", self._place(before), name)

    def remove(self, index: int) -> None:
        """One effect less."""
        before = self._present()
        self._ask(before.grown, "remove", self._place(before), index)

    def diagnose(self) -> None:
        """Let the full diagnosis find all that is missing."""
        before = self._present()
        self._ask(before.grown, "diagnose", self._place(before))

    def undo(self) -> None:
        """As it was before the last change."""
        self._go(self._present().undone())

    def redo(self) -> None:
        """What was undone last, again."""
        self._go(self._present().redone())

    def fork(self) -> None:
        """Keep the present ladder as a branch, and go on in another one."""
        self._refuse_while_busy()
        self.branches = self._present().forked()
        self.changed("ladder")

    def switch(self, place: int) -> None:
        """To another branch."""
        self._go(self._present().switched(place))

    def drop(self, place: int) -> None:
        """Forget a branch."""
        self._refuse_while_busy()
        self.branches = self._present().dropped(place)
        self.changed("ladder")

    def look_again(self) -> None:
        """What was not finished, because it was cancelled."""
        self._go(self._present())

    def whole(self) -> None:
        """The present model, fitted to all of long recordings: what can be saved."""
        self._refuse_while_busy()
        place, ladder = self._place(self._present()), self._present().present.ladder
        self._stop_work()  # a new process has the memory for it; who goes on with the ladder climbs it again
        self._aside("whole", True, "whole", place, ladder.bandwidth)

    def swarm(self, seed: int) -> None:
        """The parameters of the present model, or of the base model, by the swarm."""
        self._refuse_while_busy()
        effects = of_fit(self.ladder) if self.ladder else ()
        cutoff = self.ladder.bandwidth if self.ladder else None
        self._aside("swarm", True, "swarm", *self._files(), Chosen(effects, cutoff, seed))

    def pause(self) -> None:
        """Let the work stand still."""
        with self._work.lock:
            if self.job and self.job.paused is None:
                self._work.pause()
                self.job = replace(self.job, paused=time.monotonic())
                self.changed("job")

    def resume(self) -> None:
        """Let it go on."""
        with self._work.lock:
            if self.job and self.job.paused is not None:
                self.job = replace(self.job, began=time.monotonic() - self.job.seconds, paused=None)
                self._work.resume()
                self.changed("job")

    def cancel(self) -> None:
        """End what is being computed; what was found before stays."""
        self._stop_work()
        self._say("Cancelled; nothing has changed.")
        self._ended()

    def _present(self) -> Branches:
        if self.branches is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self.branches

    def _place(self, branches: Branches) -> views.Place:
        return views.Place(*self._files(), tuple(rung.kept for rung in branches.present.ladder.rungs))

    def _go(self, branches: Branches) -> None:
        """To the present ladder of `branches`."""
        self._ask(lambda ladder: branches, "show", self._place(branches))

    def _files(self) -> tuple[Path, Path | None]:
        if self.train is None:
            raise BadInput("a recording to train on expected, none chosen; choose one with Train")
        return self.folder.path(self.train), self.folder.path(self.validate) if self.validate else None

    def _ask(self, then: Callable[[views.LadderView], Branches], task: str, *arguments: Any) -> None:
        with self._work.lock:
            self._refuse_while_busy()
            self._then = then
            self._begin(task, urgent=True)
            self._send(task, *arguments)

    def _aside(self, what: str, urgent: bool, task: str, *arguments: Any) -> None:
        """A task that leaves the ladder alone, but may come before all was said of it."""
        with self._work.lock:
            self._unfinished = self.ladder is not None and self.failing is None
            self._begin(what, urgent)
            self._send(task, *arguments)

    def _refuse_while_busy(self) -> None:
        self._refuse_while_paused()
        if self.job and self.job.urgent:
            raise BadInput(f"one thing at a time: {self.job.what} is going on; wait for it, or cancel it")

    def _refuse_while_paused(self) -> None:
        if self.job and self.job.paused is not None:
            raise BadInput(f"work that goes on expected, {self.job.what} is paused; let it go on, or cancel it")

    def _send(self, task: str, *arguments: Any) -> None:
        self._asked += 1
        self._work.ask(task, *arguments)

    def _stop_work(self) -> None:
        with self._work.lock:
            self._work.cancel()
            self._asked, self.job, self._unfinished = 0, None, False

    def _begin(self, what: str, urgent: bool) -> None:
        self.message = ""
        self.job = Job(what, time.monotonic(), urgent)
        self.changed("job", "message")

    def _ended(self) -> None:
        """What was still awaited will not come; what is there stays as it is, and is not drawn again."""
        self.descent = None
        awaited: tuple[Part, ...] = ("choice", "failing")
        self.changed("job", "descent", *(part for part in awaited if getattr(self, part) is None))

    # What the working process says

    def _said(self, kind: str, value: Any) -> None:
        if kind == "progress" and self.job:
            self.job = replace(self.job, what=value)
        elif kind == "shown":
            self._shown(value)
        elif kind in ("idle", "failed"):
            self._asked -= 1
            if self._asked <= 0:
                self._asked, self.job = 0, None
                self._work.resume()  # it may have been paused just after its last word
            if kind == "failed":
                self._say(value)
                self._ended()
            elif self.job is None and self._unfinished:
                self._unfinished = False
                self.look_again()
        self.changed("job")

    def _shown(self, value: Any) -> None:
        if isinstance(value, views.LadderView):
            self.branches = self._then(value)
            self.choice = self.signatures = self.failing = None
            self.changed("ladder", "choice", "signatures", "failing")
        elif isinstance(value, views.Mismatch):
            self.validate = None
            self.changed("folder")
            self._say(value.why)
        elif isinstance(value, tuple):
            self.series = value
            if self.job:
                self.job = replace(self.job, urgent=False)
            self.changed("series")
        else:
            part = SHOWN_AS[type(value)]
            setattr(self, part, value)
            self.changed(part)
        if isinstance(value, views.Swarmed):
            self.descent = None
            self.changed("descent")

    def _say(self, text: str) -> None:
        self.message = text
        self.changed("message")
