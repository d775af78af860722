"""Tab to save the model: its file, the report, and equivalent terminal commands; and the verdict above all tabs."""

from nicegui import ui

from ident.identification.model_file import ModelFile
from ident.output.tables.parameters import with_meanings
from ident.workbench.pages import truth
from ident.workbench.pages.page import (
    Page,
    draw_code,
    draw_result,
    heading,
    in_background,
    quiet,
    say_what_comes,
    set_test_id,
)
from ident.workbench.state.cli_equivalent import shell_script
from ident.workbench.worker.views import StepsView


def draw(page: Page) -> None:
    """Draw the export of the current model."""
    step_list, residuals = page.session.selection.step_list, page.session.selection.analysis.residuals
    if step_list is None or residuals is None:
        say_what_comes(page, "It can be saved")
        return
    file_name = page.session.export.proposed_name(residuals.model)
    heading("Model")
    with ui.row().classes("items-center gap-3"):
        page.save_form(residuals.model, file_name, "save")
        _draw_report(page, residuals.model, step_list)
    truth.draw(page)
    heading("Equivalent commands", "q-mt-md")
    quiet("Run this in the folder of the recordings. It overwrites nothing; choose another name if the file exists.")
    draw_code(shell_script(step_list, file_name), "script")
    heading("Parameters of the current model", "q-mt-md")
    draw_result(with_meanings(step_list.steps[-1].entry.parameters))


def _draw_report(page: Page, model: ModelFile, step_list: StepsView) -> None:
    """Draw a button that creates the report on `model`, the last of `step_list`, or a link to the report."""
    export = page.session.export
    if report := export.report_name(model):
        set_test_id(ui.link("Open the report", f"/reports/{report}", new_tab=True), "open-report")
    elif export.creating_report:
        ui.label("Creating the report …")
    else:
        create = (in_background, export.create_report, model, step_list)
        button = page.button("Create the report", "report", *create, icon="description", props="outline")
        button.tooltip("Saves the model too; one HTML file to send to a colleague")


def draw_verdict(page: Page) -> None:
    """Draw what is known of the current model, and the ways on: analyse, save, open the report."""
    page.draw_on_change(_draw_pending, "job", "residuals")
    page.draw_on_change(_draw_floor, "residuals", "saved")


def _draw_pending(page: Page) -> None:
    selection = page.session.selection
    if selection.step_list is None or selection.analysis.residuals is not None:
        return
    with ui.row().classes("items-center gap-3 banner"):
        if page.session.jobs.current is not None:
            ui.label("The model is being analysed …")
        else:
            ui.label("The analysis of this model is not complete.")
            page.button("Analyse", "resume-analysis", selection.change, props="outline")


def _draw_floor(page: Page) -> None:
    selection, export = page.session.selection, page.session.export
    step_list, residuals = selection.step_list, selection.analysis.residuals
    if step_list is None or residuals is None or residuals.model.residual_test is None:
        return
    good = selection.within_noise
    with ui.row().classes(f"items-center gap-3 banner {'banner-good' if good else ''}"):
        if good:
            ui.icon("check_circle", size="sm")
        set_test_id(ui.label(residuals.model.residual_test.sentence), "floor")
        if not good:
            return
        if saved := export.saved_name(residuals.model):
            ui.label(f"Saved as {saved}.")
        else:
            props = "unelevated color=white text-color=positive"
            page.button("Save", "banner-save", export.ensure_saved, residuals.model, icon="save", props=props)
        _draw_report(page, residuals.model, step_list)
