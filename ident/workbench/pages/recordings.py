"""List of the recordings in the folder, with the choice of training and validation, and uploads."""

from nicegui import events, ui

from ident.workbench.folder import SUFFIX
from ident.workbench.pages.page import Page, notify, set_test_id
from recordings.errors import BadInput
from web.security import MAX_BODY_BYTES


def draw(page: Page) -> None:
    """Draw the list and the area for uploads."""
    root = page.session.folder.root
    ui.label("Recordings").classes("head")
    ui.label(f"in {root.name or root}").classes("quiet ellipsis w-full").tooltip(str(root))
    page.draw_on_change(_draw_list, "folder")
    ui.label(
        "Train: fit the model to this recording. Validate: compare it with this recording of another motion."
    ).classes("quiet")

    async def add(upload: events.UploadEventArguments) -> None:
        await _save_upload(page, upload)
        box.run_method("removeUploadedFiles")  # they are now in the list above

    box = ui.upload(on_upload=add, auto_upload=True, multiple=True, max_file_size=MAX_BODY_BYTES)
    box.props(f'label="Drop files here" accept={SUFFIX} flat bordered').classes("w-full q-mt-sm")
    set_test_id(box, "upload").on(
        "rejected",
        lambda: ui.notify("Only .mcap files of up to 256 MiB are accepted; copy larger ones into the folder."),
    )


def _draw_list(page: Page) -> None:
    names = page.session.folder.names(SUFFIX)
    if not names:
        ui.label("No recordings here yet: record one, or drop a file below.").classes("quiet")
    for number, name in enumerate(names):
        with ui.row().classes("w-full items-center no-wrap gap-1 q-mb-xs"):
            ui.label(name).classes("ellipsis col").tooltip(name)
            _choice_buttons(page, name, number)


def _choice_buttons(page: Page, name: str, number: int) -> None:
    """Draw Train, which withdraws the recording from validation, and Validate, which another click withdraws."""
    choose, chosen = page.session.choose, page.session.recordings
    for text, selected, action in (
        ("Train", name == chosen.train, lambda: choose(name, chosen.validate if name != chosen.validate else None)),
        (
            "Validate",
            name == chosen.validate,
            lambda: choose(chosen.train, name if name != chosen.validate else None),
        ),
    ):
        state = "unelevated aria-pressed=true" if selected else "outline aria-pressed=false"
        page.button(text, f"{text.lower()}-{number}", action, props=f"dense size=sm {state}")


async def _save_upload(page: Page, upload: events.UploadEventArguments) -> None:
    try:
        path = page.session.folder.new_file(upload.file.name, SUFFIX)
        await upload.file.save(path)
    except BadInput as error:
        notify(str(error), "warning")
    page.session.changes.mark("folder")
