"""Button that opens the sealed truth of a simulated recording, beside the current model."""

from typing import Any

from nicegui import run as background
from nicegui import ui

from ident.output.digits import number
from ident.workbench.pages.page import Page, draw_table, notify, set_test_id
from ident.workbench.reveal import is_sealed, reveal, sentences
from recordings.errors import BadInput


def draw(page: Page) -> None:
    """Draw the button if the truth of the training recording is sealed."""
    session = page.session
    train = session.recordings.train
    if train is None or not is_sealed(session.folder.root, train):
        return

    async def show() -> None:
        residuals = session.selection.residuals
        try:
            document = await background.io_bound(
                reveal, session.folder.root, train, residuals.model if residuals else None
            )
        except BadInput as error:
            notify(str(error), "warning")
            return
        truth.clear()
        with truth:
            _draw_truth(document or {"hidden": []})

    with ui.row().classes("items-center gap-3"):
        button = ui.button("Reveal", icon="visibility", on_click=show).props("outline")
        set_test_id(button, "reveal")
        ui.label(f"Opens what is hidden in the simulated robot of {train}, beside the current model.").classes(
            "quiet"
        )
    truth = set_test_id(ui.column().classes("gap-1"), "truth")


def _draw_truth(document: dict[str, Any]) -> None:
    for sentence in sentences(document):
        ui.label(sentence)
    pairs = document.get("parameters", {})
    if pairs:
        rows = [(name, number(pair["true"], 4), number(pair["found"], 4)) for name, pair in pairs.items()]
        draw_table(("parameter", "true", "found"), rows)
