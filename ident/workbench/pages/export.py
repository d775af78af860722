"""Tab to save the model: its file, the report, and equivalent terminal commands; and the verdict above all tabs."""

from nicegui import ui

from ident.basics.model_name import model_stem
from ident.identification.model_file import ModelFile
from ident.output.assessment import warning_lines
from ident.output.tables.parameters import with_meanings
from ident.workbench.pages import truth
from ident.workbench.pages.candidates import add_button
from ident.workbench.pages.page import (
    Page,
    draw_code,
    draw_result,
    heading,
    in_background,
    notify,
    quiet,
    say_what_comes,
    set_test_id,
)
from ident.workbench.programs.running import printed_by
from ident.workbench.state.cli_equivalent import report_command, shell_script
from ident.workbench.worker.views import StepsView


def draw(page: Page) -> None:
    """Draw the export of the current model."""
    made, residuals = page.session.selection.steps, page.session.selection.analysis.residuals
    if made is None or residuals is None:
        say_what_comes(page, "It can be saved")
        return
    file_name = page.session.saved.proposed_name(residuals.model)
    heading("Model")
    with ui.row().classes("items-center gap-3"):
        _save_form(page, residuals.model, file_name)
        _draw_report(page, residuals.model, made)
    truth.draw(page)
    heading("Equivalent commands", "q-mt-md")
    quiet("Run this in the folder of the recordings. It overwrites nothing; choose another name if the file exists.")
    draw_code(shell_script(made, file_name), "script")
    heading("Parameters of the current model", "q-mt-md")
    draw_result(with_meanings(made.steps[-1].entry.parameters))


def _save_form(page: Page, model: ModelFile, file_name: str) -> None:
    """Draw an input for the file name and a button that saves `model`."""
    out = ui.input("file", value=file_name).props("dense outlined").classes("min-w-64")

    def save() -> None:
        page.session.saved.save(model, str(out.value))
        notify(f"Saved {out.value} next to the recording.", "positive")

    page.button("Save next to the recording", "save", save, icon="save")


def _draw_report(page: Page, model: ModelFile, made: StepsView) -> None:
    """Draw a button that creates the report on `model`, the last of `made`, or a link to the report."""
    saved, folder = page.session.saved, page.session.folder
    if report := saved.report_on(model):
        set_test_id(ui.link("Open the report", f"/reports/{report}", new_tab=True), "open-report")
        return

    async def create() -> None:
        name = saved.ensure_saved(model)
        out = folder.free_name(model_stem(name), ".report.html")
        if await in_background(printed_by, folder.root, *report_command(made, name, out)) is not None:
            saved.add_report(name, out)

    button = page.button("Create the report", "report", create, icon="description", props="outline")
    button.tooltip("Saves the model too; one HTML file to send to a colleague")


def draw_verdict(page: Page) -> None:
    """Draw what is known of the current model, and the ways on: analyse, save, open the report."""
    page.draw_on_change(_draw_pending, "job", "residuals")
    page.draw_on_change(_draw_floor, "residuals", "advice", "saved")


def _draw_pending(page: Page) -> None:
    selection = page.session.selection
    if selection.steps is None or selection.analysis.residuals is not None:
        return
    with ui.row().classes("items-center gap-3 banner"):
        if page.session.jobs.current is not None:
            ui.label("The model is being analysed …")
        else:
            ui.label("The analysis of this model is not complete.")
            page.button("Analyse", "resume-analysis", selection.go, props="outline")


def _draw_floor(page: Page) -> None:
    selection, saved = page.session.selection, page.session.saved
    made, residuals = selection.steps, selection.analysis.residuals
    if made is None or residuals is None or residuals.model.residual_test is None:
        return
    good = selection.within_noise
    with ui.row().classes(f"items-center gap-3 banner {'banner-good' if good else ''}"):
        if good:
            ui.icon("check_circle", size="sm")
        set_test_id(ui.label(residuals.model.residual_test.sentence), "floor")
        if not good:
            _draw_advice(page)
        elif name := saved.name_of(residuals.model):
            ui.label(f"Saved as {name}.")
        else:
            props = "unelevated color=white text-color=positive"
            page.button("Save", "banner-save", saved.ensure_saved, residuals.model, icon="save", props=props)
        if good:
            _draw_report(page, residuals.model, made)
    if assessment := residuals.model.assessment:
        for line in warning_lines(assessment, certain=True):
            set_test_id(quiet(line), "fit-warning")


def _draw_advice(page: Page) -> None:
    """Say which effect would explain most, and ask whether to add it, unless the judge refuses it."""
    advice = page.session.selection.analysis.advice
    if advice is None or advice.effect is None:
        return
    what = f"{advice.effect} would explain {advice.improvement:.0%} of the square"
    text = f"{what}, but {advice.refusal}." if advice.refusal else f"{what}. Add it?"
    set_test_id(ui.label(text), "best")
    if not advice.refusal:
        add_button(page, advice.effect, "add-best")
