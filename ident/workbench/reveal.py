"""Sealed truth of a simulated recording, beside the current model: `daq reveal`, run as a process of its own."""

import json
import tempfile
from pathlib import Path
from subprocess import TimeoutExpired
from typing import Any

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.workbench.recording_process import run_daq
from recordings.errors import BadInput

_SEAL = ".sealed.json"


def is_sealed(root: Path, recording: str | None) -> bool:
    """Return whether the truth of `recording` is sealed beside it in the folder `root`."""
    return recording is not None and (root / recording).with_suffix(_SEAL).is_file()


def reveal(root: Path, recording: str, model: ModelFile | None) -> dict[str, Any]:
    """Return the document of `daq reveal` for `recording`, beside what `model` holds if there is one.

    Raises:
        BadInput: the seal is missing or broken.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "current.model.json"
        if model is not None:
            model_file.save(model, path)
        try:
            process = run_daq(root, "reveal", recording, *([str(path)] if model else []), "--json")
        except (OSError, TimeoutExpired) as error:
            raise BadInput(f"an answer of `daq reveal` expected, {error} found; run it in a terminal") from None
    if process.returncode:
        raise BadInput(process.stderr.strip().removeprefix("error: "))
    document: dict[str, Any] = json.loads(process.stdout)
    return document


def sentences(document: dict[str, Any]) -> list[str]:
    """Return what was hidden, whether it was found, and what was found but not hidden."""
    lines = []
    for effect in document["hidden"]:
        joints = f" on joint {', '.join(map(str, effect['joints']))}" if effect["joints"] else ""
        verdict = f": {effect['verdict']}" if "verdict" in effect else ""
        lines.append(f"Hidden: {effect['name']}{joints}{verdict}.")
    lines += [f"Found, but not hidden: {name}." for name in document.get("not_hidden", ())]
    return lines or ["Hidden: nothing."]
