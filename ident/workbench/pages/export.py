"""Export: model file, report, and equivalent terminal commands."""

from nicegui import run as background
from nicegui import ui

from ident.identification.model_file import ModelFile
from ident.output.tables.parameters import with_meanings
from ident.workbench.cli_equivalent import shell_script
from ident.workbench.pages import truth
from ident.workbench.pages.page import Page, draw_code, draw_table, heading, notify, set_test_id
from ident.workbench.views import StepsView


def draw(page: Page) -> None:
    """Draw the export of the current model."""
    step_list, residuals = page.session.selection.step_list, page.session.selection.residuals
    if step_list is None or residuals is None:
        ui.label(
            "The model can be saved here when it has been analysed."
            if step_list
            else "Fit a model first; it can then be saved here."
        ).classes("quiet")
        return
    file_name = page.session.export.saved_name(residuals.model) or page.session.export.free_name(step_list)
    heading("Model")
    with ui.row().classes("items-center gap-3"):
        page.save_form(residuals.model, file_name, "save")
        draw_report(page, residuals.model, step_list)
    truth.draw(page)
    heading("Equivalent commands", "q-mt-md")
    ui.label(
        "Run this in the folder of the recordings. It overwrites nothing; choose another name if the file exists."
    ).classes("quiet")
    draw_code(shell_script(step_list, file_name), "script")
    heading("Parameters of the current model", "q-mt-md")
    table = with_meanings(step_list.steps[-1].entry.parameters)
    draw_table(table.head, table.rows, table.words)


def draw_report(page: Page, model: ModelFile, step_list: StepsView) -> None:
    """Draw a button that creates the report on `model`, the last of `step_list`, or a link to the report."""
    export = page.session.export

    async def create() -> None:
        name = export.saved_name(model) or export.free_name(step_list)
        error = await background.io_bound(export.create_report, model, step_list, name)
        if error:
            notify(error, "warning")

    report = export.report_name(model)
    if report:
        set_test_id(ui.link("Open the report", f"/reports/{report}", new_tab=True), "open-report")
    elif export.creating_report:
        ui.label("Creating the report …")
    else:
        button = ui.button("Create the report", icon="description", on_click=create).props("outline")
        set_test_id(button, "report").tooltip("Saves the model too; one HTML file to send to a colleague")
