"""Export: model file, report, and equivalent terminal commands."""

import subprocess
import sys

from nicegui import run as background
from nicegui import ui

from ident.identification import model_file
from ident.workbench.cli_equivalent import report_command, shell_script
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.session import WorkbenchSession
from recordings.errors import BadInput


def draw(page: Page) -> None:
    """Draw the export of the current model."""
    page.draw_on_change(lambda: _draw(page), "residuals", "ladder")


def _draw(page: Page) -> None:
    session = page.session
    if session.ladder is None or session.residuals is None:
        pending = "The residual is being analysed; the model can then be saved here." if session.ladder else None
        ui.label(pending or "Fit a model first; it can then be saved here.").classes("quiet")
        return
    file = f"{session.ladder.train.removesuffix('.mcap')}.model.json"
    ui.label("Model").classes("head")
    if session.residuals.model is None:
        _fit_whole_button(page)
    else:
        _files(page, file)
    ui.label("Equivalent commands").classes("head q-mt-md")
    ui.label(
        "Run this in the folder of the recordings. It overwrites nothing; choose another name if the file exists."
    ).classes("quiet")
    text = shell_script(session.ladder, file)
    set_test_id(ui.code(text, language="bash").classes("w-full"), "script")
    _parameters(session)


def _fit_whole_button(page: Page) -> None:
    """Draw the button for the fit to entire long recordings."""
    ui.label(
        "The ladder uses excerpts of these long recordings; a model can be saved after a fit to all of the data."
    )
    button = ui.button(
        "Fit to the whole recording", icon="timelapse", on_click=page.handler(page.session.fit_whole_recording)
    )
    button.props("no-caps").tooltip(
        "Takes about a minute for an hour at 500 Hz; the ladder is fitted again when you continue with it"
    )
    set_test_id(button, "whole")


def _files(page: Page, file: str) -> None:
    session = page.session
    with ui.row().classes("items-center gap-3"):
        out = ui.input("file", value=file).props("dense outlined").classes("min-w-64")
        save = ui.button("Save next to the recording", icon="save").props("no-caps")
        save.on_click(page.handler(lambda: _save(session, out.value)))
        set_test_id(save, "save")
        report = ui.button("Save and create the report", icon="description").props("no-caps outline")
        report.tooltip("One HTML file to send to a colleague; takes a minute or two")
        set_test_id(report, "report")
    status = ui.label().classes("quiet")
    set_test_id(status, "report-state")

    async def create_report() -> None:
        status.text = "creating the report …"
        status.text = await background.io_bound(_make_report, session, str(out.value)) or ""

    report.on_click(create_report)


def _make_report(session: WorkbenchSession, file_name: str) -> str:
    """Run `ident report`; return a message with its result."""
    assert session.ladder is not None
    try:
        if (
            session.saved_model is None
            or session.saved_model[0] != file_name
            or session.saved_model[1] is not session.residuals
        ):
            _save_model(session, file_name)
        command = report_command(session.ladder, session.folder.existing_file(file_name).name)
    except (BadInput, OSError) as error:
        return str(error)
    process = subprocess.run(
        [sys.executable, "-c", "from ident.cli import main; main()", *command[1:]],
        cwd=session.folder.root,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    errors = [line for line in process.stderr.splitlines() if line.startswith("error")]
    return f"Created {command[-1]} next to the recording." if process.returncode == 0 else " ".join(errors)


def _save(session: WorkbenchSession, file_name: str) -> None:
    _save_model(session, file_name)
    ui.notify(f"Saved {file_name} next to the recording.", type="positive", position="bottom")


def _save_model(session: WorkbenchSession, file_name: str) -> None:
    assert session.residuals is not None
    assert session.residuals.model is not None
    model_file.save(session.residuals.model, session.folder.new_file(file_name, ".json"))
    session.saved_model = file_name, session.residuals
    session.mark_changed("folder")


def _parameters(session: WorkbenchSession) -> None:
    assert session.ladder is not None
    ui.label("Parameters of the current model").classes("head q-mt-md")
    with ui.element("table").classes("figures"):
        with ui.element("tr"):
            for title in ("name", "value", "95 % interval", "unit", "meaning"):
                with ui.element("th").classes("words" if title in ("unit", "meaning") else ""):
                    ui.label(title)
        for key, value in session.ladder.steps[-1].entry.parameters.items():
            limits = f"{value.ci95[0]:.4g} to {value.ci95[1]:.4g}" if value.ci95 else "not available"
            with ui.element("tr"):
                for text in (key, "infinite" if value.infinite else f"{value.value:.4g}", limits):
                    with ui.element("td"):
                        ui.label(text)
                for text in (value.unit, value.meaning):
                    with ui.element("td").classes("words"):
                        ui.label(text)
