"""Fit by the paper's particle swarm, and all methods of the paper."""

from nicegui import ui

from ident.workbench.pages.command import Command, draw_command
from ident.workbench.pages.forms import as_word, name_fields
from ident.workbench.pages.page import Page, heading, quiet
from ident.workbench.state.cli_equivalent import swarm_command, table2_command

_ABOUT = (
    "Fits the parameters with 300 particles, which minimise the sum of absolute residuals, objective (33), until a "
    "certificate shows that the minimum is reached within the tolerance. The current model is fitted, or the base "
    "model if there is none; your models do not change."
)


def draw(page: Page) -> None:
    """Draw the button of the swarm, and that of all methods."""
    session, folder = page.session, page.session.folder
    with ui.row().classes("items-center gap-3") as row:
        seed = ui.number("seed", value=0, step=1).classes("w-24")
        name_fields("swarm", seed=seed)
    quiet(_ABOUT)

    def fit() -> tuple[Command, tuple[str, ...]]:
        train, validate = session.recordings.files
        stem = folder.free_name(f"{train.stem}.pso", ".model.json").removesuffix(".model.json")
        held_out = validate.name if validate else None
        command = swarm_command(session.selection.steps, train.name, held_out, as_word(seed) or "0", stem)
        return command, (f"{stem}.model.json", f"{stem}.pictures")

    draw_command(page, row, "Fit by swarm", "swarm-fit", fit)
    heading("All methods of the paper", "q-mt-md")
    quiet(
        "Fits the chosen pair of recordings of a delta robot by every method and validates it: Table 2, and its "
        "figures. Without a pair, the two samples that come with this software."
    )

    def compare() -> tuple[Command, tuple[str, ...]]:
        plots = folder.free_name("table2", ".plots")
        return table2_command(session.recordings.train, session.recordings.validate, plots), (plots,)

    draw_command(page, ui.row(), "Compare all methods", "table2", compare)
