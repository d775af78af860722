"""Dialog that turns a file of another program into a recording: its columns with a plot of each, choices, done."""

from collections.abc import Callable

from nicegui import run as background
from nicegui import ui

from ident.workbench import file_import
from ident.workbench.file_import import DELTA, EXTRA, MACHINES, Choice, Column, Guess
from ident.workbench.folder import SUFFIX
from ident.workbench.pages.page import Page, heading, notify, set_test_id
from recordings.errors import BadInput


async def open_dialog(page: Page, file: str) -> None:
    """Ask what the columns of `file`, in the folder of the recordings, hold, and convert it."""
    root = page.session.folder.root
    waiting = ui.notification(f"Looking at {file} …", spinner=True, timeout=None, position="top")
    try:
        made = await background.io_bound(file_import.guess, root, file)
    except BadInput as error:
        notify(f"{file} cannot be imported: {error}", "warning")
        return
    finally:
        waiting.dismiss()
    if made is None:  # the page is being closed
        return
    with page.dialog(f"Import {file}") as dialog, ui.card().classes("import-card"):
        content = ui.column().classes("w-full gap-2")
        with content:
            _Form(page, made, dialog, content)
    dialog.open()


class _Form:
    """Table of the columns, and what concerns the whole file."""

    def __init__(self, page: Page, made: Guess, dialog: ui.dialog, content: ui.column) -> None:
        self._page, self._made, self._dialog, self._content = page, made, dialog, content
        self._columns: list[Callable[[], tuple[str, str, str]]] = []
        set_test_id(heading(f"Import {made.file}"), "import-title")
        for remark in made.remarks:
            ui.label(remark).classes("quiet")
        with ui.element("div").classes("scroll-x w-full").props("tabindex=0"), ui.element("table").classes("figures"):
            with ui.element("tr"):
                for title in ("column", "plot", "taken for", "unit", "why"):
                    with ui.element("th").classes("words"):
                        ui.label(title)
            for number, column in enumerate(made.columns):
                self._draw_row(number, column)
        with ui.row().classes("items-end gap-3"):
            machines = [*MACHINES, *page.session.folder.names(".toml")]
            self._machine = ui.select(machines, value=made.machine, label="machine").classes("min-w-36")
            self._names = ui.input("joint names in order", value=made.command_options.get("--names", ""))
            self._names.visible = "--names" in made.command_options
            self._torque = ui.number("torque per ampere [N m/A]", min=0).classes("w-48")
            self._out = ui.input("recording", value=file_import.free_name(page.session.folder.root, made.file))
        for element in (self._machine, self._names, self._torque, self._out):
            element.props("dense outlined")
        set_test_id(self._torque, "import-kt")
        self._machine.on_value_change(self._ask_what_is_needed)
        self._ask_what_is_needed()
        with ui.row().classes("w-full justify-end gap-2 dialog-actions"):
            ui.button("Not now", on_click=dialog.close).props("outline")
            button = ui.button("Import", on_click=self._convert)
            set_test_id(button, "import").props("unelevated")

    def _draw_row(self, number: int, column: Column) -> None:
        cells = [ui.element("td").classes("words") for _ in range(5)]
        with ui.element("tr") as row:
            for cell in cells:
                cell.move(row)
        with cells[0]:
            ui.label(column.name)
        with cells[1]:
            ui.html(file_import.sparkline(column.preview), sanitize=False)
        with cells[2]:
            names = [EXTRA, *self._made.quantities]
            quantity = ui.select(names, value=column.quantity or EXTRA).props("dense outlined").classes("min-w-36")
        with cells[3]:
            unit = ui.input(value=column.unit).props("dense outlined").classes("w-24")
        with cells[4]:
            ui.label(column.why).classes("quiet")
        quantity.on_value_change(self._ask_what_is_needed)
        quantity.props["aria-label"], unit.props["aria-label"] = f"{column.name} is", f"unit of {column.name}"
        set_test_id(quantity, f"import-quantity-{number}")
        set_test_id(unit, f"import-unit-{number}")
        self._columns.append(lambda: (column.name, str(quantity.value), str(unit.value or "").strip()))

    def _ask_what_is_needed(self) -> None:
        """Show the torque per ampere where currents drive the motion: no file says it."""
        quantities = [column()[1] for column in self._columns]
        self._torque.visible = file_import.needs_torque_per_ampere(quantities, str(self._machine.value))

    async def _convert(self) -> None:
        session = self._page.session
        try:
            out = session.folder.new_file(str(self._out.value), SUFFIX).name
            choice = Choice(
                tuple(column() for column in self._columns),
                str(self._machine.value or DELTA),
                self._torque.value,
                str(self._names.value or ""),
            )
            words = file_import.arguments(self._made, choice, out)
            sentences = await background.io_bound(file_import.convert, session.folder.root, words)
        except BadInput as error:
            notify(str(error), "warning")
            return
        session.changes.mark("folder")
        self._content.clear()
        with self._content:
            set_test_id(heading(f"{out} is imported"), "imported")
            for sentence in sentences or ():
                ui.label(sentence)
            with ui.row().classes("w-full justify-end"):
                self._page.button("Done", "import-done", self._finish, out, props="unelevated autofocus")

    def _finish(self, recording: str) -> None:
        """Take the recording where none was chosen, and two recordings as training and validation."""
        session = self._page.session
        self._dialog.close()
        if session.recordings.train is None:
            session.choose(recording, None)
        session.choose_the_only_pair()
