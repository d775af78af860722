"""The parameters by the paper's particle swarm, watched while it searches."""

from nicegui import ui

from ident.identification import model as file
from ident.identification.model import FittedParameter, Model
from ident.workbench import plots
from ident.workbench.pages.page import Page, name, picture
from ident.workbench.views import Swarmed

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
        name(begin, "swarm")
        seed = ui.number("seed", value=0, min=0, step=1, format="%d").props("dense outlined").classes("w-24")
        begin.on_click(page.does(lambda: session.swarm(int(seed.value or 0))))
    ui.label(_ABOUT).classes("quiet")

    def allow() -> None:
        begin.enabled = session.train is not None and (session.job is None or not session.job.urgent)

    allow()
    page.watch(allow, "job", "folder")
    page.follow(lambda: _search(page), "descent")
    page.follow(lambda: _result(page), "swarmed")


def _search(page: Page) -> None:
    session = page.session
    descent = session.descent or (session.swarmed.descent if session.swarmed else None)
    if descent is None:
        return
    name(ui.label(f"{len(descent.excess)} steps").classes("font-medium q-mt-sm"), "swarm-steps")
    picture(plots.descent(descent), "objective above its certified minimum, step by step", session.dark)


def _result(page: Page) -> None:
    found = page.session.swarmed
    if found is None:
        return
    model = found.model
    proof = model.method.certified
    if proof:
        name(
            ui.label(
                f"Objective (33): {model.method.objective:.7g} {model.effort_units[0]}, at most {proof.excess:.1e} "
                "(relative) above its certified minimum."
            ),
            "swarm-proof",
        )
    _errors(model)
    _parameters(model)
    ui.label("The same in a terminal").classes("head q-mt-md")
    name(ui.code(found.command, language="bash").classes("w-full"), "swarm-command")
    _keep(page, found)


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


def _interval(one: FittedParameter) -> str:
    return f"{one.ci95[0]:.4g} to {one.ci95[1]:.4g}" if one.ci95 else "not known"


def _row(*cells: str, cell: str = "td") -> None:
    with ui.element("tr"):
        for text in cells:
            with ui.element(cell):
                ui.label(text)


def _keep(page: Page, found: Swarmed) -> None:
    with ui.row().classes("items-center gap-3 q-mt-sm"):
        stem = found.model.train.recordings[0].name.removesuffix(".mcap")
        out = ui.input("file", value=f"{stem}.pso.model.json").props("dense outlined").classes("min-w-64")
        save = ui.button("Save beside the recording", icon="save").props("no-caps")
        save.on_click(page.does(lambda: _save(page, str(out.value), found.model)))
        name(save, "swarm-save")


def _save(page: Page, wanted: str, model: Model) -> None:
    file.save(model, page.session.folder.new(wanted, ".json"))
    page.session.changed("folder")
    ui.notify(f"Saved {wanted} beside the recording.", type="positive", position="bottom")
