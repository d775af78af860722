"""Button that opens the sealed truth of a simulated recording, beside the current model."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nicegui import ui

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from ident.output.digits import number
from ident.workbench.pages.page import Page, draw_table, in_background, quiet, set_test_id
from ident.workbench.programs.running import answer_of_daq


def draw(page: Page) -> None:
    """Draw the button if the truth of the training recording is sealed."""
    session = page.session
    train = session.recordings.train
    if train is None or not (session.folder.root / train).with_suffix(".sealed.json").is_file():
        return

    async def show() -> None:
        residuals = session.selection.analysis.residuals
        model = residuals.model if residuals else None
        document = await in_background(reveal, session.folder.root, train, model)
        if document is not None:
            truth.clear()
            with truth:
                _draw_truth(document)

    with ui.row().classes("items-center gap-3"):
        page.button("Reveal", "reveal", show, icon="visibility", props="outline")
        quiet(f"Opens what is hidden in the simulated robot of {train}, beside the current model.")
    truth = set_test_id(ui.column().classes("gap-1"), "truth")


def _draw_truth(document: Mapping[str, Any]) -> None:
    for sentence in sentences(document):
        ui.label(sentence)
    pairs = document.get("parameters", {})
    if pairs:
        rows = [(name, number(pair["true"], 4), number(pair["found"], 4)) for name, pair in pairs.items()]
        draw_table(("parameter", "true", "found"), rows)


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
