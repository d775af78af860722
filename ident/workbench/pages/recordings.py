"""List of the recordings in the folder, with the choice of training and validation, uploads, and imports."""

import os
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui

from delta_web.security import MAX_BODY_BYTES
from ident.workbench.folder import FOREIGN_SUFFIXES, SUFFIX
from ident.workbench.pages import style
from ident.workbench.pages.import_dialog import open_dialog
from ident.workbench.pages.page import Page, heading, in_background, notify, quiet, set_test_id
from ident.workbench.worker.recording_view import PREVIEW_BYTES
from recordings.errors import BadInput
from recordings.files import sha256
from recordings.reader import read
from recordings.recording import Recording

_ACCEPTED = ",".join((SUFFIX, *FOREIGN_SUFFIXES))
_NAMES_JS = "rejected => emit(rejected.map(each => each.file.name))"


def draw(page: Page) -> None:
    """Draw the list and the area for uploads."""
    root = page.session.folder.root
    heading("Recordings")
    quiet(f"in {root.name or root}").classes("ellipsis w-full").tooltip(str(root))
    page.draw_on_change(_draw_list, "folder")
    quiet("Train: fit the model to this recording. Validate: compare it with this recording of another motion.")

    async def add(upload: events.UploadEventArguments) -> None:
        await _take_upload(page, upload)
        box.run_method("removeUploadedFiles")  # they are now in the list above

    page.draw_on_change(_draw_foreign, "folder")
    page.draw_on_change(_draw_results, "folder")
    box = ui.upload(on_upload=add, auto_upload=True, multiple=True, max_file_size=MAX_BODY_BYTES)
    box.props(f'accept="{_ACCEPTED}" flat bordered').classes("w-full q-mt-sm")
    box.add_slot("header", style.UPLOAD_HEADER)
    set_test_id(box, "upload").on("rejected", _say_why_not, js_handler=_NAMES_JS)
    quiet("Recordings, ROS bags, or tables of any make: CSV, Parquet, NPZ, MAT.")
    notes = ui.textarea("notes", value=page.session.notes, on_change=partial(_take_notes, page))
    set_test_id(notes, "notes").props("dense outlined autogrow debounce=300").classes("w-full q-mt-sm")
    page.draw_on_change(_say_what_is_kept, "project")


def _say_why_not(rejected: events.GenericEventArguments) -> None:
    types = _ACCEPTED.replace(",", ", ")
    text = f"{', '.join(rejected.args)}: a file of up to 256 MiB expected, of these types: {types}; copy a larger one"
    notify(f"{text} into the folder.", "warning")


def _say_what_is_kept(page: Page) -> None:
    if page.session.interrupted:
        set_test_id(ui.label(page.session.interrupted).classes("banner"), "interrupted")
    set_test_id(quiet(page.session.project.says), "kept")


def _take_notes(page: Page, change: events.ValueChangeEventArguments[Any]) -> None:
    page.session.notes = str(change.value or "")
    page.session.changes.mark("project")


def _draw_foreign(page: Page) -> None:
    """Draw the files that `daq import` may turn into recordings."""
    folder = page.session.folder
    names = folder.foreign()
    if not names:
        return
    nothing_chosen = page.session.recordings.train is None
    fold = ui.expansion(f"Tables and bags ({len(names)})", value=nothing_chosen).classes("w-full").props("dense")
    with set_test_id(fold, "foreign"):
        for number, name in enumerate(names):
            with ui.row().classes("w-full items-center no-wrap gap-1 q-mb-xs"):
                ui.label(name).classes("ellipsis col").tooltip(name)
                start = (open_dialog, page, name)
                page.button("Import", f"import-{number}", *start, props="dense outline", label=f"Import {name}")


def _draw_results(page: Page) -> None:
    """Draw the models and the reports of the folder."""
    folder = page.session.folder
    if models := folder.models():
        with set_test_id(ui.expansion(f"Models ({len(models)})").classes("w-full").props("dense"), "models"):
            for number, name in enumerate(models):
                with ui.row().classes("w-full items-center no-wrap gap-1 q-mb-xs"):
                    ui.label(name).classes("ellipsis col").tooltip(name)
                    fit = (page.session.selection.fit, name)
                    page.button("Open", f"open-{number}", *fit, props="dense outline", label=f"Open {name}")
    if reports := folder.reports():
        with set_test_id(ui.expansion(f"Reports ({len(reports)})").classes("w-full").props("dense"), "reports"):
            for name in reports:
                ui.link(name, f"/reports/{name}", new_tab=True).classes("block ellipsis")


def _draw_list(page: Page) -> None:
    folder = page.session.folder
    names = folder.recordings()
    if not names:
        ways = "import a file below" if folder.foreign() else "drop a file below"
        quiet(f"No recordings here yet: record one, or {ways}.")
    for number, name in enumerate(names):
        with ui.row().classes("w-full items-center no-wrap gap-1 q-mb-xs"):
            ui.label(name).classes("ellipsis col").tooltip(name)
            _choice_buttons(page, name, number)


def _choice_buttons(page: Page, name: str, number: int) -> None:
    """Draw Train, which withdraws the recording from validation, and Validate, which another click withdraws."""
    chosen = page.session.recordings

    def choose(train: str | None, validate: str | None) -> None:
        what = "Another choice of recordings discards the models of this one"
        page.discard(what, lambda: page.session.choose(train, validate))

    is_train, is_validate = name == chosen.train, name == chosen.validate
    for text, selected, pair in (
        ("Train", is_train, (name, None if is_validate else chosen.validate)),
        ("Validate", is_validate, (chosen.train, None if is_validate else name)),
    ):
        state = "unelevated aria-pressed=true" if selected else "outline aria-pressed=false"
        label = f"{text}: {name}"
        page.button(text, f"{text.lower()}-{number}", choose, *pair, props=f"dense {state}", label=label)


async def _take_upload(page: Page, upload: events.UploadEventArguments) -> None:
    """Save the file in the folder, unless it cannot be read; open the dialog that imports it if it is another's."""
    session, name, suffix = page.session, upload.file.name, Path(upload.file.name).suffix
    try:
        path = session.folder.new_file(name, suffix if suffix in FOREIGN_SUFFIXES else SUFFIX, numbered=True)
        await upload.file.save(path)
    except BadInput as error:
        notify(str(error), "warning")
        return
    if session.folder.is_foreign(path.name):
        taken = await open_dialog(page, path.name)
    else:
        taken = await in_background(_check, path) is not None
    if not taken:
        path.unlink(missing_ok=True)
        return
    if path.name != name and sha256(path) == sha256(session.folder.root / name):
        path.unlink()
        notify(f"{name} is here already.", "info")
    elif path.name != name:
        notify(f"{name} is here already: the new one is {path.name}.", "info")
    session.changes.mark("folder")
    session.choose_the_only_pair()


def _check(path: Path) -> Recording:
    """Read the begin of a recording.

    Raises:
        BadInput: it is none; the folder is not named.
    """
    try:
        return read(path, PREVIEW_BYTES)
    except BadInput as error:
        raise BadInput(str(error).replace(f"{path.parent}{os.sep}", "")) from None
