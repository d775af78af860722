"""State behind the page: one session, shared by all browser tabs and kept when the page is reloaded."""

import os
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ident.dynamics.effects.library import library
from ident.fleet import check_installed
from ident.workbench.folder import FOREIGN_SUFFIXES, SUFFIX, Folder
from ident.workbench.programs.recording_process import RecordingProcess
from ident.workbench.state.chosen_recordings import ChosenRecordings
from ident.workbench.state.project import Kept, Project
from ident.workbench.state.saved_models import SavedModels
from ident.workbench.state.selection import Selection
from ident.workbench.topics import Changes, Topic
from ident.workbench.worker.jobs import Jobs
from recordings.errors import BadInput
from recordings.files import sha256
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from ident.workbench.state.watched_fleet import WatchedFleet

_KEPT_TOPICS: set[Topic] = {"folder", "steps", "tab", "project"}
"""Topics with a part that is kept in the folder."""


@dataclass
class DisplaySettings:
    """What the user is looking at."""

    tab: str = "data"
    joint: int = 0
    """From 0."""
    dark: bool = False
    series: int | None = None
    """Recording, or part of one, on the tab Fit; None: the first that is held out."""
    signals: list[str] = field(default_factory=list)
    """Signals below its torque."""
    spans: dict[str, tuple[float, float] | None] = field(default_factory=dict)
    """Zoom by recording [s]; None: all of it."""
    requested_span: tuple[str, float, float] | None = None
    """Span to be shown next: name of the recording, start and end [s]."""
    fields: dict[str, Any] = field(default_factory=dict)
    """Values of the forms."""
    printed: dict[str, tuple[str, tuple[str, ...], str]] = field(default_factory=dict)
    """By button: what the last command printed, the names of what it has written, and the command."""
    visited: set[str] = field(default_factory=set)
    """Tabs that were shown since the model was fitted."""


class WorkbenchSession:
    """The parts of a session."""

    def __init__(self, folder: Folder, effect_files: Sequence[Path] = (), store: Path | None = None) -> None:
        self.folder = folder
        self.library = library(effect_files)
        self.changes = Changes()
        self.display = DisplaySettings()
        self.jobs = Jobs(self.changes, effect_files)
        self.recordings = ChosenRecordings(folder, self.jobs, self.changes)
        self.selection = Selection(self.recordings, self.jobs, self.changes)
        self.saved = SavedModels(folder, self.changes)
        self.recorder = RecordingProcess(folder.root, self.changes)
        self.project = Project(folder.root)
        self.notes = ""
        self.interrupted = ""
        """What ran when the last workbench in this folder was killed."""
        self._saving = threading.RLock()
        self.fleet: WatchedFleet | None = None
        """The store of a fleet, if one is open."""
        if store is not None:
            check_installed()  # it needs pyarrow, the page without a store does not
            from ident.workbench.state import watched_fleet

            self.fleet = watched_fleet.WatchedFleet(store, self.changes)
            self.display.tab = "fleet"

    def take_up(self, chosen: Sequence[str] = ()) -> None:
        """Go on where the last session in this folder was left, and keep what is done from now on.

        chosen: names of the recordings to work with instead, the one to fit first.

        Raises:
            BadInput: the `chosen` recordings cannot be used together.
        """
        kept = self.project.open()
        self.notes, self.display.dark, self.jobs.durations = kept.notes, kept.dark, {**kept.durations}
        self.display.fields = {**kept.fields}
        if "fleet" not in (kept.tab, self.display.tab):
            self.display.tab = kept.tab
        pair = (chosen[0], chosen[1] if len(chosen) == 2 else None) if chosen else (kept.train, kept.validate)
        try:
            with self.jobs.worker.lock:  # the analysis of the models follows when the recording has been read
                self.choose(*pair)
                if not (why := self._why_not(kept)):
                    self.selection.take_up(kept.history)
        except BadInput as error:  # such as a recording that was deleted
            if chosen:
                raise
            why = str(error)
        if why and kept.history:
            self.project.set_aside(why)
        if kept.running:
            self.interrupted = (
                f"The workbench ended while {kept.running} was running: its drives were stopped and disabled as for "
                "an operator who leaves, and the recording ends there."
            )
        self.changes.on_mark = self._keep
        if kept.running:
            self.changes.mark("project")  # it is said once

    def _why_not(self, kept: Kept) -> str:
        """Why the models that were `kept` cannot be taken up with the chosen recordings; empty if they can."""
        chosen = self.recordings
        views = [entry.made for entry in kept.history.entries] if kept.history else []
        if any((view.train, view.validate) != (chosen.train, chosen.validate) for view in views):
            return "they are of other recordings"
        if views and {view.digests for view in views} != {tuple(sha256(file) for file in chosen.files if file)}:
            return "a recording has changed since"
        unknown = {name for view in views for step in view.steps for name, _ in step.terms} - self.library.keys()
        return f"this library has no {', '.join(sorted(unknown))}; see --effect-file" if unknown else ""

    def _keep(self, topics: set[Topic]) -> None:
        if not topics & _KEPT_TOPICS:
            return
        with self._saving:
            chosen, display, said = self.recordings, self.display, self.project.says
            kept = Kept(
                train=chosen.train,
                validate=chosen.validate,
                history=self.selection.history,
                tab=display.tab,
                dark=display.dark,
                notes=self.notes,
                running=self.recorder.run.name if self.recorder.run and self.recorder.running else None,
                fields=dict(display.fields),
                durations=dict(self.jobs.durations),
            )
            self.project.save(kept)
        if self.project.says != said:
            self.changes.mark("project")

    def choose(self, train: str | None, validate: str | None) -> None:
        """Set the recordings to work with and discard all results of the previous ones.

        Raises:
            BadInput: a file is missing, or both are the same.
        """
        self.recordings.choose(train, validate)
        self.selection.take_up()
        self.display.visited.clear()
        self.display.series = None
        self.recordings.read()

    def choose_the_only_pair(self) -> None:
        """Fit the first and validate on the second recording of a folder with two, unless a model was fitted."""
        names = self.folder.recordings()
        if len(names) == 2 and self.recordings.validate is None and self.selection.history is None:
            train = self.recordings.train if self.recordings.train in names else names[0]  # it may be deleted
            try:
                self.choose(train, next(name for name in names if name != train))
            except BadInput as error:  # of a name that not every system permits: nobody asked for this choice
                self.jobs.show_message(str(error))

    def next_command(self) -> list[str]:
        """Words of the command that goes on in a terminal where the page was left."""
        names = self.recordings.train, self.recordings.validate, self.saved.last
        train, validate, model = (name and os.path.relpath(self.folder.root / name) for name in names)
        if train is None:
            return ["daq", "record", "--traj", "fig5a", "--cycles", "3"]
        if model:
            return ["ident", "compare", model, validate or train]
        held_out = ("--validate", validate) if validate else ()
        return [str(word) for word in diagnosis([Path(train)], *held_out)]

    def close(self) -> None:
        """Stop the recording and the worker, and leave the folder to others."""
        self.recorder.close()
        self.jobs.stop()
        self.project.close()


def open_session(
    paths: Sequence[Path], effect_files: Sequence[Path] = (), store: Path | None = None
) -> WorkbenchSession:
    """Open a session on one folder, or on the folder of one or two recordings and choose these.

    Files of other programs, which the page can import, are not chosen.

    store: the folder of a fleet's results, which is shown too.

    Raises:
        BadInput: a path does not exist, or the recordings are not in one folder.
    """
    if not paths or (len(paths) == 1 and paths[0].is_dir()):
        session = WorkbenchSession(Folder.at(*paths or [Path()]), effect_files, store)
        session.take_up()
        if session.recordings.train is None:
            session.choose_the_only_pair()
        return session
    for path in paths:
        if not path.is_file() or path.suffix not in (SUFFIX, *FOREIGN_SUFFIXES):
            raise BadInput(f"a folder, or existing recordings ({SUFFIX}), expected, {path} found; check the path")
    folders = {path.absolute().parent.resolve() for path in paths}
    if len(paths) > 2 or len(folders) > 1:
        raise BadInput(
            f"one folder, or a recording to fit and one to validate on in the same folder, expected, {len(paths)} "
            f"files in {len(folders)} folders found; open their folder"
        )
    session = WorkbenchSession(Folder.at(folders.pop()), effect_files, store)
    session.take_up([path.name for path in paths if not session.folder.is_foreign(path.name)])
    return session
