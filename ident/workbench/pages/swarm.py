"""The parameters by the paper's particle swarm, watched while it searches."""

from nicegui import ui

from ident.identification import model as file
from ident.identification.model import FittedParameter, Model
from ident.workbench import plots
from ident.workbench.pages.page import Page, set_test_id, draw_figure
from ident.workbench.views import SwarmResult

_ABOUT = (
    "Lets 300 particles look for the parameters with the smallest sum of absolute residuals, objective (33), until "
    "they are where a certificate says that nothing is lower. Pause and Cancel stand above. It fits the present "
    "model, or the base model where none is fitted; the ladder stays as it is."
)


def draw(page: Page) -> None:
    """A button, the search, and what it found."""
    session = page.session
    with ui.row().classes("items-center gap-3"):
        begin = ui.button("Fit with the swarm", icon="bubble_chart").props("no-caps")
        set_test_id(begin, "swarm")
        seed = ui.number("seed", value=0, min=0, step=1, format="%d").props("dense outlined").classes("w-24")
        begin.on_click(page.handler(lambda: session.swarm(int(seed.value or 0))))
    ui.label(_ABOUT).classes("quiet")

    def allow() -> None:
        begin.enabled = session.train is not None and (session.job is None or not session.job.blocking)

    allow()
    page.call_on_change(allow, "job", "folder")
    page.draw_on_change(lambda: _draw_progress(page), "descent")
    page.draw_on_change(lambda: _draw_result(page), "swarmed")


def _draw_progress(page: Page) -> None:
    session = page.session
    descent = session.swarm_progress or (session.swarm_result.progress if session.swarm_result else None)
    if descent is None:
        return
    set_test_id(ui.label(f"{len(descent.excess)} steps").classes("font-medium q-mt-sm"), "swarm-steps")
    draw_figure(plots.swarm_convergence(descent), "objective above its certified minimum, step by step", session.dark)


def _draw_result(page: Page) -> None:
    found = page.session.swarm_result
    if found is None:
        return
    model = found.model
    proof = model.method.certified
    if proof:
        set_test_id(
            ui.label(
                f"Objective (33): {model.method.objective:.7g} {model.effort_units[0]}, at most {proof.excess:.1e} "
                "(relative) above its certified minimum."
            ),
            "swarm-proof",
        )
    _errors(model)
    _parameters(model)
    ui.label("The same in a terminal").classes("head q-mt-md")
    set_test_id(ui.code(found.command, language="bash").classes("w-full"), "swarm-command")
    _save_row(page, found)


def _errors(model: Model) -> None:
    ui.label("Error").classes("head q-mt-sm")
    units = model.effort_units
    with ui.element("table").classes("figures"):
        _row("", *(f"joint {j} [{unit} RMS]" for j, unit in enumerate(units, start=1)), cell="th")
        _row("training", *(f"{value:.4f}" for value in model.train.fitted.rms))
        if model.validate_:
            _row("held out", *(f"{value:.4f}" for value in model.validate_.fitted.rms))


def _parameters(model: Model) -> None:
    ui.label(f"Parameters{', relative' if model.relative else ''}").classes("head q-mt-md")
    with ui.element("table").classes("figures"):
        _row("name", "value", "95 % interval", "unit", "at bound", cell="th")
        for one in model.parameters:
            _row(one.name, f"{one.value:.4g}", _interval(one), one.unit, "yes" if one.at_bound else "")


def _interval(parameter: FittedParameter) -> str:
    return f"{parameter.ci95[0]:.4g} to {parameter.ci95[1]:.4g}" if parameter.ci95 else "not known"


def _row(*cells: str, cell: str = "td") -> None:
    with ui.element("tr"):
        for text in cells:
            with ui.element(cell):
                ui.label(text)


def _save_row(page: Page, swarm_result: SwarmResult) -> None:
    with ui.row().classes("items-center gap-3 q-mt-sm"):
        stem = swarm_result.model.train.recordings[0].name.removesuffix(".mcap")
        out = ui.input("file", value=f"{stem}.pso.model.json").props("dense outlined").classes("min-w-64")
        save = ui.button("Save beside the recording", icon="save").props("no-caps")
        save.on_click(page.handler(lambda: _save(page, str(out.value), swarm_result.model)))
        set_test_id(save, "swarm-save")


def _save(page: Page, file_name: str, model: Model) -> None:
    file.save(model, page.session.folder.new_file(file_name, ".json"))
    page.session.mark_changed("folder")
    ui.notify(f"Saved {file_name} beside the recording.", type="positive", position="bottom")
