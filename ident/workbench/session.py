"""State behind the page: one session, shared by all browser tabs and kept when the page is reloaded."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ident.dynamics.effects.library import library
from ident.workbench.chosen_recordings import ChosenRecordings
from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.jobs import Jobs
from ident.workbench.model_export import ModelExport
from ident.workbench.model_selection import ModelSelection
from ident.workbench.recording_process import RecordingProcess
from ident.workbench.swarm_fit import SwarmFit
from ident.workbench.topics import Changes
from recordings.errors import BadInput


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


def open_session(paths: Sequence[Path], effect_files: Sequence[Path] = ()) -> WorkbenchSession:
    """Open a session on one folder, or on the folder of one or two recordings and choose these.

    Raises:
        BadInput: a path does not exist, or the recordings are not in one folder.
    """
    if not paths or (len(paths) == 1 and paths[0].is_dir()):
        return WorkbenchSession(Folder.at(paths[0] if paths else Path()), effect_files)
    for path in paths:
        if not path.is_file() or path.suffix != SUFFIX:
            raise BadInput(f"a folder, or existing recordings ({SUFFIX}), expected, {path} found; check the path")
    folders = {path.absolute().parent.resolve() for path in paths}
    if len(paths) > 2 or len(folders) > 1:
        raise BadInput(
            f"one folder, or a recording to fit and one to validate on in the same folder, expected, {len(paths)} "
            f"files in {len(folders)} folders found; open their folder"
        )
    session = WorkbenchSession(Folder.at(folders.pop()), effect_files)
    session.choose(paths[0].name, paths[1].name if len(paths) == 2 else None)
    return session
