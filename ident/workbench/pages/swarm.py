"""Fit by the paper's particle swarm, with its convergence."""

from nicegui import ui

from ident.identification.model_file import ModelFile
from ident.output.digits import interval, number
from ident.workbench import plots
from ident.workbench.pages.page import Page, draw_code, draw_table, heading, set_test_id

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
    ui.label(_ABOUT).classes("quiet")

    def update_enabled(page: Page) -> None:
        start.enabled = session.recordings.train is not None and not session.jobs.blocked

    page.call_now_and_on_change(update_enabled, "job", "folder")
    page.draw_on_change(_draw_progress, "swarm_progress")
    page.draw_on_change(_draw_result, "swarm_result")


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
    certificate = model.method.certified
    if certificate:
        set_test_id(
            ui.label(
                f"Objective (33): {model.method.objective:.7g} {model.effort_units[0]}, at most "
                f"{certificate.excess:.1e} (relative) above its certified minimum."
            ),
            "swarm-proof",
        )
    _errors(model)
    _parameters(model)
    heading("Equivalent command", "q-mt-md")
    draw_code(result.command, "swarm-command")
    with ui.row().classes("items-center gap-3 q-mt-sm"):
        stem = model.train.recordings[0].name.removesuffix(".mcap")
        page.save_form(model, f"{stem}.pso.model.json", "swarm-save")


def _errors(model: ModelFile) -> None:
    heading("Error", "q-mt-sm")
    joints = [f"joint {j} [{unit} RMS]" for j, unit in enumerate(model.effort_units, start=1)]
    agreements = {"training": model.train, "held out": model.validate_}
    draw_table(
        ["", *joints],
        [
            (label, *(f"{value:.4f}" for value in agreement.fitted.rms))
            for label, agreement in agreements.items()
            if agreement
        ],
    )


def _parameters(model: ModelFile) -> None:
    heading(f"Parameters{', relative' if model.relative else ''}", "q-mt-md")
    rows = (
        (
            parameter.name,
            number(parameter.value, 4),
            interval(*parameter.shape_ci95) if parameter.shape_ci95 else "–",
            parameter.unit,
            "yes" if parameter.at_bound else "",
        )
        for parameter in model.all_parameters
    )
    draw_table(("parameter", "value", "95 % interval", "unit", "at bound"), rows, words=(0, 3))
