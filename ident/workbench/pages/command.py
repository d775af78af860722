"""A command on the page: it runs, and what it prints and writes is shown and can be downloaded."""

import io
import shlex
import zipfile
from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from ident.workbench.pages.page import Page, draw_code, in_background
from ident.workbench.programs.running import printed_by

Command = tuple[str, ...]


def draw_command(
    page: Page, row: ui.row, text: str, test_id: str, words: Callable[[], tuple[Command, tuple[str, ...]]]
) -> None:
    """Draw a button in `row` that runs a command, and what comes of it below.

    words: returns the command, and the names of the files and folders that it writes.
    """
    session = page.session

    async def start() -> None:
        command, written = words()
        printed = await in_background(printed_by, session.folder.root, *command)
        if printed is not None:
            session.display.printed[test_id] = printed, written, f"{shlex.join(command)}\n"
            session.changes.mark("folder", "printed")

    def draw(page: Page) -> None:
        if test_id in session.display.printed:
            printed, written, command = session.display.printed[test_id]
            draw_code(printed, f"{test_id}-printed", language=None)
            draw_written(page, written)
            draw_code(command, f"{test_id}-command")

    with row:
        page.button(text, test_id, start, icon="play_arrow")
    page.draw_on_change(draw, "printed")


def draw_written(page: Page, names: tuple[str, ...]) -> None:
    """Draw what was written in the folder of the recordings: its pictures, and a button to download each."""
    for name in names:
        path = page.session.folder.root / name
        if pictures := sorted(path.rglob("*.png")) or [path] * (path.suffix == ".png"):
            with ui.expansion(f"Pictures ({len(pictures)})", value=len(pictures) == 1).classes("w-full"):
                for picture in pictures:
                    ui.image(picture).classes("picture").props(f'alt="{picture.stem}"')
        label = f"Download {name}{'.zip' if path.is_dir() else ''}"
        page.button(label, f"download-{name}", _download, path, icon="download", props="outline")


def _download(path: Path) -> None:
    if path.is_dir():
        ui.download.content(packed(path), f"{path.name}.zip")
    else:
        ui.download.file(path)


def packed(folder: Path) -> bytes:
    """Return a ZIP archive of `folder`."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            archive.write(file, file.relative_to(folder.parent))
    return written.getvalue()
