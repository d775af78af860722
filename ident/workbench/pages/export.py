"""What to take away: the model, and the commands that do the same."""

import subprocess
import sys

from nicegui import run as background
from nicegui import ui

from ident.identification import model
from ident.workbench.cli_equivalent import report_command, script
from ident.workbench.pages.page import Page, name
from ident.workbench.session import Session
from recordings.errors import BadInput


def draw(page: Page) -> None:
    """Of the present model."""
    page.follow(lambda: _draw(page), "failing", "ladder")


def _draw(page: Page) -> None:
    session = page.session
    if session.ladder is None or session.failing is None:
        fitted = "The model is being looked at; it can then be saved here." if session.ladder else None
        ui.label(fitted or "Fit a model first; it can then be saved here.").classes("quiet")
        return
    file = f"{session.ladder.train.removesuffix('.mcap')}.model.json"
    ui.label("Model").classes("head")
    if session.failing.model is None:
        _whole(page)
    else:
        _files(page, file)
    ui.label("The same in a terminal").classes("head q-mt-md")
    ui.label(
        "To run beside the recordings. It overwrites nothing: where a model of that name was saved, give another one."
    ).classes("quiet")
    text = script(session.ladder, file)
    name(ui.code(text, language="bash").classes("w-full"), "script")
    _parameters(session)


def _whole(page: Page) -> None:
    """Of long recordings only parts were looked at."""
    ui.label("The ladder looks at parts of these long recordings; a model to keep is fitted to all of them.")
    fit = ui.button("Fit to the whole recording", icon="timelapse", on_click=page.does(page.session.whole))
    fit.props("no-caps").tooltip(
        "For an hour at 500 Hz about a minute; the ladder is then climbed again when you go on with it"
    )
    name(fit, "whole")


def _files(page: Page, file: str) -> None:
    session = page.session
    with ui.row().classes("items-center gap-3"):
        out = ui.input("file", value=file).props("dense outlined").classes("min-w-64")
        save = ui.button("Save beside the recording", icon="save").props("no-caps")
        save.on_click(page.does(lambda: _save(session, out.value)))
        name(save, "save")
        report = ui.button("Save, and make the report", icon="description").props("no-caps outline")
        report.tooltip("One HTML file to send to a colleague; takes a minute or two")
        name(report, "report")
    told = ui.label().classes("quiet")
    name(told, "report-state")

    async def make() -> None:
        told.text = "making the report …"
        told.text = await background.io_bound(_report, session, str(out.value)) or ""

    report.on_click(make)


def _report(session: Session, wanted: str) -> str:
    """Let `ident report` make it, as anybody would; what came of it."""
    assert session.ladder is not None
    try:
        if session.saved is None or session.saved[0] != wanted or session.saved[1] is not session.failing:
            _keep(session, wanted)
        command = report_command(session.ladder, session.folder.path(wanted).name)
    except (BadInput, OSError) as error:
        return str(error)
    done = subprocess.run(
        [sys.executable, "-c", "from ident.cli import main; main()", *command[1:]],
        cwd=session.folder.root,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    errors = [line for line in done.stderr.splitlines() if line.startswith("error")]
    return f"Made {command[-1]} beside the recording." if done.returncode == 0 else " ".join(errors)


def _save(session: Session, wanted: str) -> None:
    _keep(session, wanted)
    ui.notify(f"Saved {wanted} beside the recording.", type="positive", position="bottom")


def _keep(session: Session, wanted: str) -> None:
    assert session.failing is not None
    assert session.failing.model is not None
    model.save(session.failing.model, session.folder.new(wanted, ".json"))
    session.saved = wanted, session.failing
    session.changed("folder")


def _parameters(session: Session) -> None:
    assert session.ladder is not None
    ui.label("Parameters of the present model").classes("head q-mt-md")
    with ui.element("table").classes("figures"):
        with ui.element("tr"):
            for title in ("name", "value", "95 % interval", "unit", "what it is"):
                with ui.element("th").classes("words" if title in ("unit", "what it is") else ""):
                    ui.label(title)
        for key, value in session.ladder.rungs[-1].entry.parameters.items():
            limits = f"{value.ci95[0]:.4g} to {value.ci95[1]:.4g}" if value.ci95 else "not known from these data"
            with ui.element("tr"):
                for text in (key, "never" if value.never else f"{value.value:.4g}", limits):
                    with ui.element("td"):
                        ui.label(text)
                for text in (value.unit, value.meaning):
                    with ui.element("td").classes("words"):
                        ui.label(text)
