"""What is made of a model next to the recordings: its file, a report, and exports for controllers and simulators."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.basics.model_name import model_stem
from ident.export import targets
from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.folder import Folder
from ident.workbench.programs.running import run_ident
from ident.workbench.state.cli_equivalent import report_command
from ident.workbench.topics import Changes
from ident.workbench.worker.views import StepsView
from recordings.errors import BadInput

ENDINGS = {"c": "_c", "csv": ".feedforward.csv", "fmu": ".fmu", "mjcf": ".xml", "urdf": ".urdf"}
"""End of the name of an export by its target; C is a folder."""


@dataclass(frozen=True, eq=False)
class ControllerFiles:
    """An export that was written."""

    model: ModelFile
    model_name: str
    out: str
    """Names of the file of the model, and of the file or folder that was written."""
    command: tuple[str, ...]
    document: dict[str, Any]
    """Effects that are carried and not carried, and the torque that is lost: `carried.json`."""


class ModelExport:
    """Writes new files into the folder of the recordings; reports and exports by the command `ident`."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self._saved: dict[str, ModelFile] = {}
        """Models that were saved, by file name."""
        self._reports: dict[str, str] = {}
        """Names of the reports that were created, by the file name of the model."""
        self._exports: list[ControllerFiles] = []
        """Exports of this session."""
        self.creating_report = self.exporting = False

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

    def export_of(self, model: ModelFile) -> ControllerFiles | None:
        """Return the last export of `model`."""
        return next((files for files in reversed(self._exports) if files.model is model), None)

    def report(self, name: str) -> Path:
        """Return the path of the report `name`.

        Raises:
            BadInput: it was not created by this session.
        """
        if name not in self._reports.values():
            raise BadInput(f"a report of this session expected, '{name[:80]}' found; create it on the tab Save")
        return self._folder.existing_file(name)

    def proposed_name(self, model: ModelFile) -> str:
        """Return the file name of `model`, or a new one if it was not saved."""
        stem = model.train.recordings[0].name.removesuffix(".mcap")
        return self.saved_name(model) or self._folder.free_name(stem, ".model.json")

    def free_name(self, model_name: str, target: str) -> str:
        """Return a name for an export of the model in the file `model_name`."""
        return self._folder.free_name(model_stem(model_name), ENDINGS[target])

    def save(self, model: ModelFile, file_name: str) -> None:
        """Save `model` to a new file.

        Raises:
            BadInput: the name is invalid, or the file exists.
        """
        model_file.save(model, self._folder.new_file(file_name, ".json"))
        self._saved[file_name] = model
        self._changes.mark("folder", "saved")

    def ensure_saved(self, model: ModelFile) -> str:
        """Save `model` unless it was saved; return the name of its file."""
        name = self.proposed_name(model)
        if self._saved.get(name) is not model:
            self.save(model, name)
        return name

    def create_report(self, model: ModelFile, step_list: StepsView) -> None:
        """Save `model`, the last of `step_list`, unless it was saved, and run `ident report`.

        Raises:
            BadInput: `ident` refuses, or the model was deleted meanwhile.
        """
        self.creating_report = True
        self._changes.mark("saved")
        try:
            name = self.ensure_saved(model)
            command = report_command(step_list, self._folder.existing_file(name).name)
            run_ident(self._folder.root, *command[1:])
            self._reports[name] = command[-1]
        finally:
            self.creating_report = False
            self._changes.mark("saved")

    def export(self, model: ModelFile, target: str, out: str, motion: str | None) -> None:
        """Save `model` unless it was saved, and write it to `out`.

        motion: trajectory of a table, and of the torque that is lost; None: the motion of the fit.

        Raises:
            BadInput: `out` exists, or is no plain name with the ending of this target, or `ident` refuses.
        """
        path = self._folder.new_file(out, "" if target == "c" else "." + ENDINGS[target].rsplit(".", 1)[-1])
        name = self.ensure_saved(model)
        command = ("export", name, "--to", target, "-o", path.name, *(("--traj", motion) if motion else ()))
        self.exporting = True
        self._changes.mark("use")
        try:
            run_ident(self._folder.root, *command)
            carried = targets.load(target).carried_file(path)
            document = json.loads(carried.read_text(encoding="utf-8"))
            self._exports.append(ControllerFiles(model, name, path.name, ("ident", *command), document))
        finally:
            self.exporting = False
            self._changes.mark("use", "folder")


def targets_of(mechanism: str) -> tuple[str, ...]:
    """Names of the targets that a `mechanism` can be exported to."""
    unwritten = {"delta": ("urdf",), "axes": ("mjcf", "urdf")}.get(mechanism, ())
    return tuple(name for name in ENDINGS if name not in unwritten)
