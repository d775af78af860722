"""State behind the page: one session, shared by all browser tabs and kept when the page is reloaded."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from ident.dynamics.effects.library import library
from ident.fleet import check_installed
from ident.workbench.folder import FOREIGN_SUFFIXES, SUFFIX, Folder
from ident.workbench.programs.feedforward_comparison import FeedforwardComparison
from ident.workbench.programs.recording_process import RecordingProcess
from ident.workbench.state.chosen_recordings import ChosenRecordings
from ident.workbench.state.model_export import ModelExport
from ident.workbench.state.model_selection import ModelSelection
from ident.workbench.state.swarm_fit import SwarmFit
from ident.workbench.topics import Changes
from ident.workbench.worker.jobs import Jobs
from recordings.command_line import repeated
from recordings.errors import BadInput
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from ident.workbench.state.watched_fleet import WatchedFleet


@dataclass
class DisplaySettings:
    """What the user is looking at."""

    tab: str = "data"
    joint: int = 0
    """From 0."""
    dark: bool = False
    requested_span: tuple[str, float, float] | None = None
    """Span to be shown next: name of the recording, start and end [s]."""
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
        self.selection = ModelSelection(self.recordings, self.jobs, self.changes)
        self.swarm = SwarmFit(self.recordings, self.jobs, self.changes)
        self.export = ModelExport(folder, self.changes)
        self.recorder = RecordingProcess(folder.root, self.changes)
        self.comparison = FeedforwardComparison(folder, self.recorder, self.changes)
        self.fleet: WatchedFleet | None = None
        """The store of a fleet, if one is open."""
        if store is not None:
            check_installed()  # it needs pyarrow, the page without a store does not
            from ident.workbench.state import watched_fleet

            self.fleet = watched_fleet.WatchedFleet(store, self.changes)
            self.display.tab = "fleet"

    def choose(self, train: str | None, validate: str | None) -> None:
        """Set the recordings to work with and discard all results of the previous ones.

        Raises:
            BadInput: a file is missing, or both are the same.
        """
        self.recordings.choose(train, validate)
        self.selection.clear()
        self.swarm.clear()
        self.display.visited.clear()
        self.recordings.read()

    def choose_the_only_pair(self) -> None:
        """Fit the first and validate on the second recording of a folder with two, unless a model was fitted."""
        names = self.folder.recordings()
        if len(names) == 2 and self.recordings.validate is None and self.selection.step_list is None:
            train = self.recordings.train if self.recordings.train in names else names[0]  # it may be deleted
            try:
                self.choose(train, next(name for name in names if name != train))
            except BadInput as error:  # of a name that not every system permits: nobody asked for this choice
                self.jobs.show_message(str(error))

    def next_command(self) -> list[str]:
        """Words of the command that goes on in a terminal where the page was left."""
        names = [name for name in (self.recordings.train, self.recordings.validate, self.export.last_saved) if name]
        paths = {name: os.path.relpath(self.folder.root / name) for name in names}
        train, validate, model = self.recordings.train, self.recordings.validate, self.export.last_saved
        if train is None:
            return ["daq", "record", "--traj", "fig5a", "--cycles", "3"]
        if model:
            return ["ident", "compare", paths[model], paths[validate or train]]
        held_out = [paths[validate]] if validate else []
        return [str(word) for word in diagnosis([Path(paths[train])], *repeated("--validate", held_out))]

    def close(self) -> None:
        """Stop the recording and the worker."""
        self.recorder.close()
        self.jobs.stop()


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
    chosen = [path.name for path in paths if not session.folder.is_foreign(path.name)]
    if chosen:
        session.choose(chosen[0], chosen[1] if len(chosen) == 2 else None)
    return session
