"""Saving of models and creation of reports next to the recordings."""

from pathlib import Path

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.cli_equivalent import report_command
from ident.workbench.folder import Folder
from ident.workbench.ident_process import run_ident
from ident.workbench.topics import Changes
from ident.workbench.views import StepsView
from recordings.errors import BadInput


class ModelExport:
    """Writes new files into the folder of the recordings."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self._saved: dict[str, ModelFile] = {}
        """Models that were saved, by file name."""
        self._reports: dict[str, str] = {}
        """Names of the reports that were created, by the file name of the model."""
        self.creating_report = False

    @property
    def last_saved(self) -> str | None:
        """File name of the model that was saved last."""
        return next(reversed(self._saved), None)

    def saved_name(self, model: ModelFile) -> str | None:
        """Return the file name under which `model` was saved last."""
        return next((name for name, saved in reversed(self._saved.items()) if saved is model), None)

    def report_name(self, model: ModelFile) -> str | None:
        """Return the file name of the report on `model`."""
        return next((report for name, report in self._reports.items() if self._saved[name] is model), None)

    def ensure_saved(self, model: ModelFile, step_list: StepsView) -> str:
        """Save `model`, the last of `step_list`, unless it was saved; return the name of its file."""
        name = self.saved_name(model)
        if name is None:
            name = self.free_name(step_list)
            self.save(model, name)
        return name

    def report(self, name: str) -> Path:
        """Return the path of the report `name`.

        Raises:
            BadInput: it was not created by this session.
        """
        if name not in self._reports.values():
            raise BadInput(f"a report of this session expected, '{name[:80]}' found; create it on the tab Save")
        return self._folder.existing_file(name)

    def free_name(self, step_list: StepsView) -> str:
        """Return a name for a new model file."""
        return self._folder.free_name(step_list.train.removesuffix(".mcap"), ".model.json")

    def save(self, model: ModelFile, file_name: str) -> None:
        """Save `model` to a new file.

        Raises:
            BadInput: the name is invalid, or the file exists.
        """
        model_file.save(model, self._folder.new_file(file_name, ".json"))
        self._saved[file_name] = model
        self._changes.mark("folder", "saved")

    def create_report(self, model: ModelFile, step_list: StepsView, file_name: str) -> str | None:
        """Save `model`, the last of `step_list`, unless it was saved, and run `ident report`; return any error."""
        self.creating_report = True
        self._changes.mark("saved")
        try:
            return self._create_report(model, step_list, file_name)
        except (BadInput, OSError) as error:
            return str(error)
        finally:
            self.creating_report = False
            self._changes.mark("saved")

    def _create_report(self, model: ModelFile, step_list: StepsView, file_name: str) -> str | None:
        if self._saved.get(file_name) is not model:
            self.save(model, file_name)
        command = report_command(step_list, self._folder.existing_file(file_name).name)
        error = run_ident(self._folder.root, *command[1:])
        if error is None:
            self._reports[file_name] = command[-1]
        return error
