"""Export of models for controllers and simulators, next to the recordings."""

import json
from dataclasses import dataclass
from typing import Any

from ident import plugins
from ident.export import targets
from ident.identification.model_file import ModelFile
from ident.model_name import model_stem
from ident.workbench.folder import Folder
from ident.workbench.ident_process import run_ident
from ident.workbench.topics import Changes

ENDINGS = {"c": "_c", "csv": ".feedforward.csv", "fmu": ".fmu", "mjcf": ".xml"}
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


class ControllerExport:
    """Runs `ident export` in the folder of the recordings."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self.files: list[ControllerFiles] = []
        """Exports of this session."""
        self.running = False

    def of(self, model: ModelFile) -> ControllerFiles | None:
        """Return the last export of `model`."""
        return next((files for files in reversed(self.files) if files.model is model), None)

    def free_name(self, model_name: str, target: str) -> str:
        """Return a name for an export of the model in the file `model_name`."""
        return self._folder.free_name(model_stem(model_name), ENDINGS[target])

    def export(self, model: ModelFile, model_name: str, target: str, out: str, motion: str | None) -> str | None:
        """Write `model`, which is saved as `model_name`, to `out`; return what went wrong.

        motion: trajectory of a table, and of the torque that is lost; None: the motion of the fit.

        Raises:
            BadInput: `out` exists, or is no plain name with the ending of this target.
        """
        path = self._folder.new_file(out, "" if target == "c" else "." + ENDINGS[target].rsplit(".", 1)[-1])
        command = ("export", model_name, "--to", target, "-o", path.name, *(("--traj", motion) if motion else ()))
        self.running = True
        self._changes.mark("use")
        try:
            error = run_ident(self._folder.root, *command)
            if error is None:
                carried = targets.load(target).carried_file(path)
                document = json.loads(carried.read_text(encoding="utf-8"))
                self.files.append(ControllerFiles(model, model_name, path.name, ("ident", *command), document))
            return error
        finally:
            self.running = False
            self._changes.mark("use", "folder")


def targets_of(mechanism: str) -> tuple[str, ...]:
    """Names of the targets that a `mechanism` can be exported to."""
    return tuple(name for name in plugins.names("ident.export.targets") if name != "mjcf" or mechanism == "delta")
