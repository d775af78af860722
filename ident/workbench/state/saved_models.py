"""Models of this session that were saved next to the recordings, and the reports on them."""

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.folder import Folder
from ident.workbench.topics import Changes


class SavedModels:
    """File names of the models; nothing is overwritten."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self._saved: dict[str, ModelFile] = {}
        """Models by file name."""
        self._reports: dict[str, str] = {}
        """Names of the reports by the file name of their model."""

    @property
    def last(self) -> str | None:
        """File name of the model that was saved last."""
        return next(reversed(self._saved), None)

    def name_of(self, model: ModelFile) -> str | None:
        """Return the file name under which `model` was saved last."""
        return next((name for name, saved in reversed(self._saved.items()) if saved is model), None)

    def report_on(self, model: ModelFile) -> str | None:
        """Return the file name of the report on `model`."""
        return self._reports.get(self.name_of(model) or "")

    def proposed_name(self, model: ModelFile) -> str:
        """Return the file name of `model`, or a new one if it was not saved."""
        stem = model.train.recordings[0].name.removesuffix(".mcap")
        return self.name_of(model) or self._folder.free_name(stem, ".model.json")

    def save(self, model: ModelFile, file_name: str) -> None:
        """Save `model` to a new file.

        Raises:
            BadInput: the name is invalid, or the file exists.
        """
        model_file.save(model, self._folder.new_file(file_name, ".json"))
        self._saved[file_name] = model
        self._changes.mark("folder", "saved")

    def ensure_saved(self, model: ModelFile) -> str:
        """Save `model` unless it was saved; return the name of its file.

        Raises:
            BadInput: it was saved, and deleted meanwhile.
        """
        if name := self.name_of(model):
            return self._folder.existing_file(name).name
        self.save(model, name := self.proposed_name(model))
        return name

    def add_report(self, model_name: str, report: str) -> None:
        """Note the `report` on the model in the file `model_name`."""
        self._reports[model_name] = report
        self._changes.mark("folder", "saved")
