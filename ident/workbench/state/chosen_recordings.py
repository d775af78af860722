"""Recordings that the user has chosen: to fit, to validate, and to look at."""

from pathlib import Path

from ident.workbench.folder import Folder
from ident.workbench.topics import Changes
from ident.workbench.worker.jobs import Jobs
from ident.workbench.worker.views import Mismatch, RecordingView, View
from recordings.errors import BadInput


class ChosenRecordings:
    """Names of the training and of the validation recording, and the recording that is shown."""

    def __init__(self, folder: Folder, jobs: Jobs, changes: Changes) -> None:
        self._folder, self._jobs, self._changes = folder, jobs, changes
        self.train: str | None = None
        self.validate: str | None = None
        self.shown: RecordingView | None = None

    @property
    def files(self) -> tuple[Path, Path | None]:
        """Return the training and the validation recording.

        Raises:
            BadInput: none is chosen, or a file is missing.
        """
        if self.train is None:
            raise BadInput("a training recording expected, none chosen; choose one with Train")
        validate = self._folder.existing_file(self.validate) if self.validate else None
        return self._folder.existing_file(self.train), validate

    def model(self, name: str) -> Path:
        """Return the file of a model in the folder.

        Raises:
            BadInput: there is no such file.
        """
        return self._folder.existing_file(name)

    def choose(self, train: str | None, validate: str | None) -> None:
        """Set the recordings and stop the job on the previous ones.

        Raises:
            BadInput: a file is missing, or both are the same.
        """
        for name in (train, validate):
            if name is not None:
                self._folder.existing_file(name)
        if train is not None and train == validate:
            raise BadInput(
                "another recording expected for validation, the training recording found; "
                "errors on training data are too optimistic"
            )
        if self._jobs.current:  # it is about the previous ones
            self._jobs.stop()
        self.train, self.validate, self.shown = train, validate, None
        self._changes.mark("folder", "recording")

    def read(self) -> None:
        """Show the training recording, and check that the validation recording comes from the same rig."""
        if self.train is not None:
            self._submit(*self.files)

    def show(self, name: str) -> None:
        """Show another recording."""
        self._submit(self._folder.existing_file(name))

    def _submit(self, *files: Path | None) -> None:
        self._jobs.submit("reading", self._receive, "view_recording", *files, blocking=False)

    def _receive(self, view: View) -> None:
        match view:
            case Mismatch(reason):
                self.validate = None
                self._jobs.show_message(reason)
                self._changes.mark("folder")
            case RecordingView():
                self.shown = view
                self._changes.mark("recording")
