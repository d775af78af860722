"""Fit by the paper's particle swarm, with its convergence."""

from nicegui import ui

from ident.output.tables.parameters import agreement, fitted
from ident.workbench.pages import plots
from ident.workbench.pages.command import Command, draw_command
from ident.workbench.pages.page import Page, draw_code, draw_result, heading, quiet, set_test_id
from ident.workbench.state.cli_equivalent import table2_command

_ABOUT = (
    "Fits the parameters with 300 particles, which minimise the sum of absolute residuals, objective (33), until a "
    "certificate shows that the minimum is reached within the tolerance. The current model is fitted, or the base "
    "model if there is none; the step_list does not change. Pause and Cancel are at the top."
)


def draw(page: Page) -> None:
    """Draw the button, the convergence and the result."""
    session = page.session
    with ui.row().classes("items-center gap-3"):
        start = page.button(
            "Fit by swarm",
            "swarm",
            lambda: session.swarm.start(int(seed.value or 0), session.selection.step_list),
            icon="bubble_chart",
        )
        seed = ui.number("seed", value=0, min=0, step=1, format="%d").props("dense outlined").classes("w-24")
    quiet(_ABOUT)

    def update_enabled(page: Page) -> None:
        start.enabled = session.recordings.train is not None and not session.jobs.blocked

    page.watch(update_enabled, "job", "folder")
    page.draw_on_change(_draw_progress, "swarm_progress")
    page.draw_on_change(_draw_result, "swarm_result")
    heading("All methods of the paper", "q-mt-md")
    quiet(
        "Fits the chosen pair of recordings of a delta robot by every method and validates it: Table 2, and its "
        "figures. Without a pair, the two samples that come with this software."
    )

    def compare() -> tuple[Command, tuple[str, ...]]:
        plots = session.folder.free_name("table2", ".plots")
        return table2_command(session.recordings.train, session.recordings.validate, plots), (plots,)

    draw_command(page, ui.row(), "Compare all methods", "table2", compare)


def _draw_progress(page: Page) -> None:
    progress = page.session.swarm.progress
    if progress is None:
        return
    set_test_id(ui.label(f"{len(progress.excess)} steps").classes("font-medium q-mt-sm"), "swarm-steps")
    page.draw_figure(plots.swarm_convergence(progress), "objective above its certified minimum, step by step")


def _draw_result(page: Page) -> None:
    result = page.session.swarm.result
    if result is None:
        return
    model = result.model
    if certificate := model.method.certified:
        sentence = (
            f"Objective (33): {model.method.objective:.7g} {model.effort_units[0]}, at most {certificate.excess:.1e} "
            "(relative) above its certified minimum."
        )
        set_test_id(ui.label(sentence), "swarm-proof")
    for title, table in (
        ("Error", agreement(model)),
        (f"Parameters{', relative' if model.relative else ''}", fitted(model)),
    ):
        heading(title, "q-mt-md")
        draw_result(table)
    heading("Equivalent command", "q-mt-md")
    draw_code(page.session.swarm.command, "swarm-command")
    with ui.row().classes("items-center gap-3 q-mt-sm"):
        stem = model.train.recordings[0].name.removesuffix(".mcap")
        page.save_form(model, f"{stem}.pso.model.json", "swarm-save")
