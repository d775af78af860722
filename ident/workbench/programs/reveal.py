"""Sealed truth of a simulated recording, beside the current model, as `daq reveal` opens it."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.programs.running import answer_of_daq


def is_sealed(root: Path, recording: str | None) -> bool:
    """Return whether the truth of `recording` is sealed beside it in the folder `root`."""
    return recording is not None and (root / recording).with_suffix(".sealed.json").is_file()


def reveal(root: Path, recording: str, model: ModelFile | None) -> Mapping[str, Any]:
    """Return the document of `daq reveal` for `recording`, beside what `model` holds if there is one.

    Raises:
        BadInput: the seal is missing or broken.
    """
    if model is None:
        return answer_of_daq(root, "reveal", recording)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "current.model.json"
        model_file.save(model, path)
        return answer_of_daq(root, "reveal", recording, str(path))


def sentences(document: Mapping[str, Any]) -> list[str]:
    """Return what was hidden, whether it was found, and what was found but not hidden."""
    lines = []
    for effect in document["hidden"]:
        joints = f" on joint {', '.join(map(str, effect['joints']))}" if effect["joints"] else ""
        verdict = f": {effect['verdict']}" if "verdict" in effect else ""
        lines.append(f"Hidden: {effect['name']}{joints}{verdict}.")
    lines += [f"Found, but not hidden: {name}." for name in document.get("not_hidden", ())]
    return lines or ["Hidden: nothing."]
