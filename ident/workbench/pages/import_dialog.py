"""Dialog that turns a file of another program into a recording: its columns with a plot of each, choices, done."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from nicegui import ui

from ident.workbench.folder import SUFFIX
from ident.workbench.pages.forms import name_fields
from ident.workbench.pages.page import Cell, Page, draw_table, heading, in_background, quiet, set_test_id
from ident.workbench.programs import file_import
from ident.workbench.programs.file_import import DELTA, EXTRA, MACHINES, FileColumn, FileGuess


async def open_dialog(page: Page, file: str) -> bool:
    """Ask what the columns of `file`, in the folder of the recordings, hold, and convert it; False: nobody can."""
    made = await in_background(file_import.guess, page.session.folder.root, file)
    if made is None:
        return False
    with page.dialog(f"Import {file}") as dialog, ui.card().classes("import-card"):
        content = ui.column().classes("w-full gap-2")
        with content:
            _Form(page, made, dialog, content)
    dialog.open()
    return True


class _Form:
    """Table of the columns, and what concerns the whole file."""

    def __init__(self, page: Page, made: FileGuess, dialog: ui.dialog, content: ui.column) -> None:
        self._page, self._made, self._dialog, self._content = page, made, dialog, content
        self._quantities: list[ui.select] = []
        self._units: list[ui.input] = []
        set_test_id(heading(f"Import {made.file}"), "import-title")
        for remark in made.remarks:
            quiet(remark)
        rows = [self._cells(number, column) for number, column in enumerate(made.columns)]
        draw_table(("column", "plot", "taken for", "unit", "why"), rows, words=range(5))
        with ui.row().classes("items-end gap-3"):
            machines = [*MACHINES, *page.session.folder.names(".toml")]
            self._machine = ui.select(machines, value=made.machine, label="machine").classes("min-w-36")
            self._names = ui.input("joint names in order", value=made.options.get("--names", ""))
            self._names.visible = "--names" in made.options
            self._torque = ui.number("torque per ampere [N m/A]").classes("w-48")
            self._out = ui.input("recording", value=page.session.folder.free_name(Path(made.file).stem, SUFFIX))
        name_fields("import", machine=self._machine, names=self._names, kt=self._torque, out=self._out)
        self._machine.on_value_change(self._ask_what_is_needed)
        self._ask_what_is_needed()
        with ui.row().classes("w-full justify-end gap-2 dialog-actions"):
            ui.button("Not now", on_click=dialog.close).props("outline")
            page.button("Import", "import", self._convert, props="unelevated")

    def _cells(self, number: int, column: FileColumn) -> list[Cell]:
        def quantity() -> None:
            names = [EXTRA, *self._made.quantities]
            field = ui.select(names, value=column.quantity or EXTRA, on_change=self._ask_what_is_needed)
            field.classes("min-w-36").props["aria-label"] = f"{column.name} is"
            name_fields("import", **{f"quantity-{number}": field})
            self._quantities.append(field)

        def unit() -> None:
            field = ui.input(value=column.unit).classes("w-24")
            field.props["aria-label"] = f"unit of {column.name}"
            name_fields("import", **{f"unit-{number}": field})
            self._units.append(field)

        plot = partial(ui.html, _sparkline(column.preview), sanitize=False)
        return [column.name, plot, quantity, unit, partial(quiet, column.why)]

    def _ask_what_is_needed(self) -> None:
        """Show the torque per ampere where currents drive the motion: no file says it."""
        quantities = [str(field.value) for field in self._quantities]
        self._torque.visible = file_import.needs_torque_per_ampere(quantities, str(self._machine.value))

    def _converted(self, out: str) -> tuple[str, ...]:
        session, torque_per_ampere = self._page.session, self._torque.value
        columns = [
            (column.name, str(quantity.value), str(unit.value or "").strip())
            for column, quantity, unit in zip(self._made.columns, self._quantities, self._units, strict=True)
        ]
        session.folder.new_file(out, SUFFIX)
        machine, names = str(self._machine.value or DELTA), str(self._names.value or "")
        words = file_import.arguments(self._made, columns, machine, out, torque_per_ampere, names)
        return file_import.convert(session.folder.root, words)

    async def _convert(self) -> None:
        session, out = self._page.session, str(self._out.value)
        sentences = await in_background(self._converted, out)
        if sentences is None:
            return
        session.changes.mark("folder")
        self._content.clear()
        with self._content:
            set_test_id(heading(f"{out} is imported"), "imported")
            for sentence in sentences:
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


def _sparkline(values: Sequence[float | None], width: int = 150, height: int = 32) -> str:
    """Return an SVG picture of `values` over their index, with gaps."""
    numbers = [value for value in values if value is not None]
    if not numbers:
        return ""
    low, span = min(numbers), (max(numbers) - min(numbers)) or 1.0
    step = width / max(len(values) - 1, 1)
    path, pen = [], "M"
    for index, value in enumerate(values):
        if value is not None:
            path.append(f"{pen}{index * step:.1f} {height - 2 - (value - low) / span * (height - 4):.1f}")
        pen = "M" if value is None else "L"
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" aria-hidden="true">'
        f'<path d="{"".join(path)}" fill="none" stroke="currentColor" stroke-width="1.2"/></svg>'
    )
