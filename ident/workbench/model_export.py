"""Saving of models and creation of reports next to the recordings."""

import subprocess
import sys

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.cli_equivalent import report_command
from ident.workbench.folder import Folder
from ident.workbench.topics import Changes
from ident.workbench.views import LadderView
from recordings.errors import BadInput


class ModelExport:
    """Writes new files into the folder of the recordings."""

    def __init__(self, folder: Folder, changes: Changes) -> None:
        self._folder, self._changes = folder, changes
        self._saved: dict[str, ModelFile] = {}
        """Models that were saved, by file name."""

    def save(self, model: ModelFile, file_name: str) -> None:
        """Save `model` to a new file.

        Raises:
            BadInput: the name is invalid, or the file exists.
        """
        model_file.save(model, self._folder.new_file(file_name, ".json"))
        self._saved[file_name] = model
        self._changes.mark("folder")

    def create_report(self, model: ModelFile, ladder: LadderView, file_name: str) -> str:
        """Save `model`, the last of `ladder`, unless it was saved, and run `ident report`; return a message."""
        try:
            if self._saved.get(file_name) is not model:
                self.save(model, file_name)
            command = report_command(ladder, self._folder.existing_file(file_name).name)
        except (BadInput, OSError) as error:
            return str(error)
        process = subprocess.run(
            [sys.executable, "-c", "from ident.cli import main; main()", *command[1:]],
            cwd=self._folder.root,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        if process.returncode == 0:
            return f"Created {command[-1]} next to the recording."
        return " ".join(line for line in process.stderr.splitlines() if line.startswith("error"))
