"""Models that were saved next to the recordings, and the reports on them."""

from functools import lru_cache
from pathlib import Path

import numpy as np

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.folder import Folder
from ident.workbench.topics import Changes
from recordings.errors import BadInput


class SavedModels:
    """File names of the models; nothing is overwritten. Which file holds a model is what the file says."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self.last: str | None = None
        """File name of the model that was saved last."""
        self._reports: dict[str, str] = {}
        """Names of the reports by the file name of their model."""

    def name_of(self, model: ModelFile) -> str | None:
        """Return the name of the file that holds `model`."""
        for name in self._folder.names(".json"):
            saved = _loaded(self._folder.root / name)
            if saved and saved.effects == model.effects and saved.train.recordings == model.train.recordings:
                known, here = ([each.value for each in file.parameters] for file in (saved, model))
                if len(known) == len(here) and np.allclose(known, here, rtol=1e-9, atol=0):
                    return name
        return None

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
        self.last = file_name
        self._changes.mark("folder", "saved")

    def ensure_saved(self, model: ModelFile) -> str:
        """Save `model` unless it was saved; return the name of its file."""
        if not (name := self.name_of(model)):
            self.save(model, name := self.proposed_name(model))
        return name

    def add_report(self, model_name: str, report: str) -> None:
        """Note the `report` on the model in the file `model_name`."""
        self._reports[model_name] = report
        self._changes.mark("folder", "saved")


def _loaded(path: Path) -> ModelFile | None:
    """The model in a file; None where it holds none, or was deleted meanwhile."""
    try:
        return _unchanged(path, path.stat().st_mtime_ns)
    except OSError:
        return None


@lru_cache(maxsize=64)
def _unchanged(path: Path, mtime_ns: int) -> ModelFile | None:
    """The model in a file, kept while the file does not change; None where it holds none."""
    try:
        return model_file.load(path)
    except BadInput:
        return None
