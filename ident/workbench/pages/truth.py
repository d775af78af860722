"""Button that opens the ground truth of a simulated recording, beside the current model."""

from nicegui import ui

from ident.workbench.pages.command import Command, draw_command
from ident.workbench.pages.page import Page, quiet


def draw(page: Page) -> None:
    """Draw the button if the truth of the training recording is sealed."""
    session = page.session
    train = session.recordings.train
    if train is None or not (session.folder.root / train).with_suffix(".sealed.json").is_file():
        return

    def reveal() -> tuple[Command, tuple[str, ...]]:
        residuals = session.selection.analysis.residuals
        return ("daq", "reveal", train, *((session.saved.ensure_saved(residuals.model),) if residuals else ())), ()

    row = ui.row().classes("items-center gap-3")
    with row:
        quiet(f"Opens what is hidden in the simulated robot of {train}, beside the current model, which it saves.")
    draw_command(page, row, "Reveal", "reveal", reveal)
