"""Export: model file, report, and equivalent terminal commands."""

from nicegui import run as background
from nicegui import ui

from ident.identification.model_file import ModelFile
from ident.output.report.sections import parameter_values
from ident.workbench.cli_equivalent import shell_script
from ident.workbench.pages.page import Page, draw_table, set_test_id
from ident.workbench.views import LadderView


def draw(page: Page) -> None:
    """Draw the export of the current model."""
    ladder, residuals = page.session.selection.ladder, page.session.selection.residuals
    if ladder is None or residuals is None:
        ui.label(
            "The residual is being analysed; the model can then be saved here."
            if ladder
            else "Fit a model first; it can then be saved here."
        ).classes("quiet")
        return
    file_name = f"{ladder.train.removesuffix('.mcap')}.model.json"
    ui.label("Model").classes("head")
    _files(page, residuals.model, ladder, file_name)
    ui.label("Equivalent commands").classes("head q-mt-md")
    ui.label(
        "Run this in the folder of the recordings. It overwrites nothing; choose another name if the file exists."
    ).classes("quiet")
    set_test_id(ui.code(shell_script(ladder, file_name), language="bash").classes("w-full"), "script")
    ui.label("Parameters of the current model").classes("head q-mt-md")
    table = parameter_values.table(ladder.steps[-1].entry.parameters)
    draw_table(table.head, table.rows, table.words)


def _files(page: Page, model: ModelFile, ladder: LadderView, file_name: str) -> None:
    async def create_report() -> None:
        status.text = "creating the report …"
        create = page.session.export.create_report
        status.text = await background.io_bound(create, model, ladder, str(out.value)) or ""

    with ui.row().classes("items-center gap-3"):
        out = page.save_form(model, file_name, "save")
        report = ui.button("Save and create the report", icon="description", on_click=create_report)
        set_test_id(report, "report").props("outline").tooltip(
            "One HTML file to send to a colleague; takes a minute or two"
        )
    status = set_test_id(ui.label().classes("quiet"), "report-state")
