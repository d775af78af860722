"""Fit by the paper's particle swarm, with its convergence."""

from nicegui import ui

from ident.identification import model_file as file
from ident.identification.model_file import FittedParameter, ModelFile
from ident.workbench import plots
from ident.workbench.pages.page import Page, draw_figure, set_test_id
from ident.workbench.views import SwarmResult

_ABOUT = (
    "Fits the parameters with 300 particles, which minimise the sum of absolute residuals, objective (33), until a "
    "certificate shows that the minimum is reached within the tolerance. The current model is fitted, or the base "
    "model if there is none; the ladder does not change. Pause and Cancel are at the top."
)


def draw(page: Page) -> None:
    """Draw the button, the convergence and the result."""
    session = page.session
    with ui.row().classes("items-center gap-3"):
        start = ui.button("Fit by swarm", icon="bubble_chart").props("no-caps")
        set_test_id(start, "swarm")
        seed = ui.number("seed", value=0, min=0, step=1, format="%d").props("dense outlined").classes("w-24")
        start.on_click(page.handler(lambda: session.swarm(int(seed.value or 0))))
    ui.label(_ABOUT).classes("quiet")

    def update_enabled() -> None:
        start.enabled = session.train is not None and (session.job is None or not session.job.blocking)

    update_enabled()
    page.call_on_change(update_enabled, "job", "folder")
    page.draw_on_change(lambda: _draw_progress(page), "swarm_progress")
    page.draw_on_change(lambda: _draw_result(page), "swarm_result")


def _draw_progress(page: Page) -> None:
    session = page.session
    progress = session.swarm_progress or (session.swarm_result.progress if session.swarm_result else None)
    if progress is None:
        return
    set_test_id(ui.label(f"{len(progress.excess)} steps").classes("font-medium q-mt-sm"), "swarm-steps")
    draw_figure(
        plots.swarm_convergence(progress), "objective above its certified minimum, step by step", session.dark
    )


def _draw_result(page: Page) -> None:
    result = page.session.swarm_result
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
    ui.label("Equivalent command").classes("head q-mt-md")
    set_test_id(ui.code(result.command, language="bash").classes("w-full"), "swarm-command")
    _save_row(page, result)


def _errors(model: ModelFile) -> None:
    ui.label("Error").classes("head q-mt-sm")
    units = model.effort_units
    with ui.element("table").classes("figures"):
        _row("", *(f"joint {j} [{unit} RMS]" for j, unit in enumerate(units, start=1)), cell="th")
        _row("training", *(f"{value:.4f}" for value in model.train.fitted.rms))
        if model.validate_:
            _row("held out", *(f"{value:.4f}" for value in model.validate_.fitted.rms))


def _parameters(model: ModelFile) -> None:
    ui.label(f"Parameters{', relative' if model.relative else ''}").classes("head q-mt-md")
    with ui.element("table").classes("figures"):
        _row("name", "value", "95 % interval", "unit", "at bound", cell="th")
        for parameter in model.parameters:
            _row(
                parameter.name,
                f"{parameter.value:.4g}",
                _interval(parameter),
                parameter.unit,
                "yes" if parameter.at_bound else "",
            )


def _interval(parameter: FittedParameter) -> str:
    return f"{parameter.ci95[0]:.4g} to {parameter.ci95[1]:.4g}" if parameter.ci95 else "not available"


def _row(*cells: str, cell: str = "td") -> None:
    with ui.element("tr"):
        for text in cells:
            with ui.element(cell):
                ui.label(text)


def _save_row(page: Page, swarm_result: SwarmResult) -> None:
    with ui.row().classes("items-center gap-3 q-mt-sm"):
        stem = swarm_result.model.train.recordings[0].name.removesuffix(".mcap")
        out = ui.input("file", value=f"{stem}.pso.model.json").props("dense outlined").classes("min-w-64")
        save = ui.button("Save next to the recording", icon="save").props("no-caps")
        save.on_click(page.handler(lambda: _save(page, str(out.value), swarm_result.model)))
        set_test_id(save, "swarm-save")


def _save(page: Page, file_name: str, model: ModelFile) -> None:
    file.save(model, page.session.folder.new_file(file_name, ".json"))
    page.session.mark_changed("folder")
    ui.notify(f"Saved {file_name} next to the recording.", type="positive", position="bottom")
