"""Button that opens the sealed truth of a simulated recording, beside the current model."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from ident.output.digits import number
from ident.workbench.pages.page import Page, draw_table, in_background, quiet, set_test_id
from ident.workbench.programs.reveal import is_sealed, reveal, sentences


def draw(page: Page) -> None:
    """Draw the button if the truth of the training recording is sealed."""
    session = page.session
    train = session.recordings.train
    if train is None or not is_sealed(session.folder.root, train):
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
        button = ui.button("Reveal", icon="visibility", on_click=show).props("outline")
        set_test_id(button, "reveal")
        quiet(f"Opens what is hidden in the simulated robot of {train}, beside the current model.")
    truth = set_test_id(ui.column().classes("gap-1"), "truth")


def _draw_truth(document: Mapping[str, Any]) -> None:
    for sentence in sentences(document):
        ui.label(sentence)
    pairs = document.get("parameters", {})
    if pairs:
        rows = [(name, number(pair["true"], 4), number(pair["found"], 4)) for name, pair in pairs.items()]
        draw_table(("parameter", "true", "found"), rows)
