"""State behind the page: one session, shared by all browser tabs and kept when the page is reloaded."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ident.dynamics.effects.library import library
from ident.workbench.chosen_recordings import ChosenRecordings
from ident.workbench.folder import Folder
from ident.workbench.jobs import Jobs
from ident.workbench.model_export import ModelExport
from ident.workbench.model_selection import ModelSelection
from ident.workbench.recording_process import RecordingProcess
from ident.workbench.swarm_fit import SwarmFit
from ident.workbench.topics import Changes


@dataclass
class DisplaySettings:
    """What the user is looking at."""

    tab: str = "data"
    joint: int = 0
    """From 0."""
    dark: bool = False
    requested_span: tuple[str, float, float] | None = None
    """Span to be shown next: name of the recording, start and end [s]."""


class WorkbenchSession:
    """The parts of a session."""

    def __init__(self, folder: Folder, effect_files: Sequence[Path] = ()) -> None:
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

    def choose(self, train: str | None, validate: str | None) -> None:
        """Set the recordings to work with and discard all results of the previous ones.

        Raises:
            BadInput: a file is missing, or both are the same.
        """
        self.recordings.choose(train, validate)
        self.selection.clear()
        self.swarm.clear()
        self.recordings.read()

    def close(self) -> None:
        """Stop the recording and the worker."""
        self.recorder.close()
        self.jobs.stop()
