"""Shared by all parts of the page: redrawing after changes, buttons, tables, figures and notifications."""

import time
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, TypeVar

from nicegui import ui

from ident.identification.model_file import ModelFile
from ident.workbench import plots
from ident.workbench.plots import Figure
from ident.workbench.session import WorkbenchSession
from ident.workbench.topics import Topic
from recordings.errors import BadInput

Element = TypeVar("Element", bound=ui.element)
Cell = str | Callable[[], object]
"""Cell of a table: its text, or a function that draws it."""


@dataclass
class _Watch:
    callback: Callable[["Page"], None]
    topics: tuple[Topic, ...]
    min_interval: float
    count: int
    last_call: float = 0.0


class Page:
    """One browser tab that shows the session."""

    def __init__(self, session: WorkbenchSession) -> None:
        self.session = session
        self.show_tab: Callable[[str], object] = lambda tab: None
        """Show a tab of the page."""
        self.after_action: Callable[[], None] = lambda: None
        """Update the header at once, because the server ignores clicks on buttons that it believes to be hidden."""
        self._watches: list[_Watch] = []

    def draw_on_change(self, draw: Callable[["Page"], None], *topics: Topic) -> ui.element:
        """Call `draw` here, and again whenever one of `topics` changes; return the container of its elements."""
        container = ui.element("div").classes("w-full")

        def redraw(page: Page) -> None:
            container.clear()
            with container:
                draw(page)

        self.call_now_and_on_change(redraw, *topics)
        return container

    def call_now_and_on_change(
        self, callback: Callable[["Page"], None], *topics: Topic, min_interval: float = 0.0
    ) -> None:
        """Call `callback`, and again as `call_on_change` does."""
        callback(self)
        self.call_on_change(callback, *topics, min_interval=min_interval)

    def call_on_change(self, callback: Callable[["Page"], None], *topics: Topic, min_interval: float = 0.0) -> None:
        """Call `callback` whenever one of `topics` changes, but not again within `min_interval` [s]."""
        self._watches.append(_Watch(callback, topics, min_interval, self.session.changes.count(topics)))

    def poll(self) -> None:
        """Redraw what has changed since the last call."""
        self.session.recorder.mark_seen()
        now = time.monotonic()
        for watch in self._watches:
            count = self.session.changes.count(watch.topics)
            if count != watch.count and now - watch.last_call >= watch.min_interval:
                watch.count, watch.last_call = count, now
                watch.callback(self)

    def handler(self, action: Callable[..., Any], *arguments: Any) -> Callable[[], None]:
        """Return an event handler that calls `action` and shows its errors."""

        def handle() -> None:
            try:
                action(*arguments)
            except (BadInput, OSError) as error:
                notify(str(error), "warning")
            self.after_action()

        return handle

    def button(
        self,
        text: str,
        test_id: str,
        action: Callable[..., Any],
        *arguments: Any,
        icon: str | None = None,
        props: str = "",
    ) -> ui.button:
        """Draw a button that calls `action` with `arguments` and shows its errors."""
        button = ui.button(text, icon=icon, on_click=self.handler(action, *arguments))
        return set_test_id(button.props(props), test_id)

    def save_form(self, model: ModelFile, file_name: str, test_id: str) -> ui.input:
        """Draw an input for the file name and a button that saves `model`; return the input."""
        out = ui.input("file", value=file_name).props("dense outlined").classes("min-w-64")

        def save() -> None:
            self.session.export.save(model, str(out.value))
            notify(f"Saved {out.value} next to the recording.", "positive")

        self.button("Save next to the recording", test_id, save, icon="save")
        return out

    def draw_figure(self, figure: Figure, label: str) -> ui.plotly:
        """Draw a figure; `label` is its description for screen readers."""
        plot = ui.plotly(plots.with_theme(figure, self.session.display.dark)).classes("w-full")
        # Plotly forgets a figure's own height when its tab is left and shown again.
        plot.style(f"height: {figure['layout']['height']}px")
        plot.props["role"], plot.props["aria-label"] = "img", label
        return plot

    def update_figure(self, plot: ui.plotly, figure: Figure) -> None:
        """Show another figure in `plot`."""
        plot.update_figure(plots.with_theme(figure, self.session.display.dark))


def draw_table(
    titles: Sequence[str], rows: Iterable[Sequence[Cell]], words: Collection[int] = (), classes: str = ""
) -> None:
    """Draw a table; the columns `words` are aligned to the left."""
    with ui.element("table").classes(f"figures {classes}"):
        for tag, cells in [("th", titles), *(("td", row) for row in rows)]:
            with ui.element("tr"):
                for column, cell in enumerate(cells):
                    with ui.element(tag).classes("words" if column in words else ""):
                        (partial(ui.label, cell) if isinstance(cell, str) else cell)()


def notify(text: str, kind: Literal["positive", "warning", "info"]) -> None:
    """Show `text` for a while."""
    ui.notify(text, type=kind, position="bottom", timeout=8000, close_button=True)


def set_test_id(element: Element, test_id: str) -> Element:
    """Give `element` an identifier for tests, and return it."""
    element.props["data-test"] = test_id
    return element
