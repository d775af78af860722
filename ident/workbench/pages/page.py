"""Shared by all parts of the page: redrawing after changes, buttons, tables, figures and notifications."""

import asyncio
import time
from collections.abc import Callable, Collection, Coroutine, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from inspect import iscoroutine
from subprocess import TimeoutExpired
from typing import Any, Literal, TypeVar

from nicegui import events, ui
from nicegui import run as background

from ident.output.figures.time_plots import Span
from ident.output.tables import ResultTable
from ident.workbench.figure import Figure, with_theme
from ident.workbench.programs.running import Cancellable, without_options
from ident.workbench.state.session import WorkbenchSession
from ident.workbench.topics import Topic
from recordings.errors import BadInput

Result = TypeVar("Result")
Element = TypeVar("Element", bound=ui.element)
Cell = str | Callable[[], object]
"""Cell of a table: its text, or a function that draws it."""
_PATIENCE = 2.0
"""Time after which what goes on in the background is said, and can be cancelled [s]."""


@dataclass
class _Watch:
    callback: Callable[["Page"], None]
    topics: tuple[Topic, ...]
    inside: ui.element
    """Element that it changes; it ends with it."""
    count: int
    """Number of changes that it has shown."""


class Page:
    """One browser tab that shows the session."""

    def __init__(self, session: WorkbenchSession, dialogs: ui.element) -> None:
        """`dialogs`: container of the dialogs, which stay when the part that opened them is drawn again."""
        self.session, self._dialogs = session, dialogs
        self.show_tab: Callable[[str], object] = lambda tab: None
        """Show a tab of the page."""
        self.after_action: Callable[[], None] = lambda: None
        """Update the header at once, because the server ignores clicks on buttons that it believes to be hidden."""
        self._watches: list[_Watch] = []
        self.zoomable: list[ZoomablePlot] = []
        """Its time plots: those of one recording are zoomed together."""

    def draw_on_change(self, draw: Callable[["Page"], None], *topics: Topic) -> ui.element:
        """Call `draw` here, and again whenever one of `topics` changes; return the container of its elements."""
        container = ui.element("div").classes("w-full")

        def redraw(page: Page) -> None:
            container.clear()
            with container:
                draw(page)

        with container:
            self.watch(redraw, *topics)
        return container

    def watch(self, callback: Callable[["Page"], None], *topics: Topic, now: bool = True) -> None:
        """Call `callback` whenever one of `topics` changes, and `now`, as long as its element is there."""
        self._watches.append(_Watch(callback, topics, ui.context.slot.parent, self.session.changes.count(topics)))
        if now:
            callback(self)

    def poll(self) -> None:
        """Show what has changed since the last call: changes come from other threads, many at a time."""
        self._watches = [watch for watch in self._watches if not watch.inside.is_deleted]
        for watch in tuple(self._watches):
            count = self.session.changes.count(watch.topics)
            if count != watch.count and not watch.inside.is_deleted:
                watch.count = count  # before the call: what changes meanwhile is shown again
                watch.callback(self)

    def handler(
        self, action: Callable[..., Any], *arguments: Any, show_busy: Callable[[bool], object] = lambda busy: None
    ) -> Callable[[], Any]:
        """Return an event handler that calls `action`, and shows its errors.

        While an asynchronous one goes on, another press does nothing, and `show_busy` is told so.
        """
        goes_on = False

        @contextmanager
        def shown() -> Iterator[None]:
            try:
                yield
            except (BadInput, OSError) as error:
                notify(str(error), "warning")
            finally:
                self.after_action()

        async def finish(result: Coroutine[Any, Any, Any]) -> None:
            nonlocal goes_on
            with self._dialogs, shown():  # the button may be gone before it ends
                try:
                    await result
                finally:
                    goes_on = False
                    show_busy(goes_on)

        def handle() -> Coroutine[Any, Any, None] | None:
            nonlocal goes_on
            with shown():
                if not goes_on and iscoroutine(result := action(*arguments)):
                    goes_on = True
                    show_busy(goes_on)
                    return finish(result)
            return None

        return handle

    def button(
        self,
        text: str,
        test_id: str,
        action: Callable[..., Any],
        *arguments: Any,
        icon: str | None = None,
        props: str = "",
        label: str = "",
    ) -> ui.button:
        """Draw a button that calls `action` with `arguments` and shows its errors.

        label: name for screen readers, where `text` alone does not say what is meant.
        """
        button = ui.button(text, icon=icon).props(props)
        button.on_click(self.handler(action, *arguments, show_busy=partial(_show_busy, button)))
        if label:
            button.props["aria-label"] = label
        return set_test_id(button, test_id)

    def dialog(self, title: str) -> ui.dialog:
        """Return a closed dialog, which is deleted when it is closed again; `title` is for screen readers."""
        with self._dialogs:
            dialog = ui.dialog()
        dialog.props["aria-label"] = title
        dialog.on("hide", dialog.delete)
        return dialog

    def ask(self, question: str, yes: str, no: str, action: Callable[[], Any]) -> None:
        """Ask `question` in a dialog, and call `action` if the answer is `yes`."""

        def agree() -> None:
            dialog.close()
            action()

        with self.dialog(yes) as dialog, ui.card():
            set_test_id(ui.label(question), "question")
            with ui.row().classes("w-full justify-end gap-2"):
                self.button(no, "answer-no", dialog.close, props="outline autofocus")
                self.button(yes, "answer-yes", agree, props="color=negative unelevated")
        dialog.open()

    def discard(self, what: str, action: Callable[[], Any]) -> None:
        """Call `action`, which discards the models; ask first if more would be lost than one fit."""
        if self.session.selection.has_changes:
            question = f"{what}: effects added, branches, undo."
            self.ask(question, "Discard them", "Keep them", action)
        else:
            action()

    def draw_figure(self, figure: Figure, label: str) -> ui.plotly:
        """Draw a figure; `label` is its description for screen readers."""
        plot = ui.plotly(with_theme(figure, self.session.display.dark)).classes("w-full")
        # Plotly forgets a figure's own height when its tab is left and shown again.
        plot.style(f"height: {figure['layout']['height']}px")
        plot.props["role"], plot.props["aria-label"] = "figure", label
        return plot

    def zoom(self, recording: str, span: Span | None) -> None:
        """Show `span` [s] of a recording in all its plots; None: all of it."""
        self.session.display.spans[recording] = span
        self.zoomable = [item for item in self.zoomable if not item.plot.is_deleted]
        for item in self.zoomable:
            if item.recording() == recording:
                item.show()

    def update_figure(self, plot: ui.plotly, figure: Figure) -> None:
        """Show another figure in `plot`."""
        plot.style(f"height: {figure['layout']['height']}px")
        plot.update_figure(with_theme(figure, self.session.display.dark))


class ZoomablePlot:
    """Time plot of `make_figure(span)` that loads its points again at every zoom; `full_span` returns all of it.

    The zoom belongs to the `recording`, whose name is returned: all its plots follow, and it stays when one is drawn
    anew.
    """

    def __init__(
        self,
        page: Page,
        recording: Callable[[], str],
        make_figure: Callable[[Span], Figure],
        full_span: Callable[[], Span],
        label: str,
    ) -> None:
        self._page, self.recording, self._make_figure, self._full_span = page, recording, make_figure, full_span
        self.plot = page.draw_figure(make_figure(self.span), label)
        self.plot.on("plotly_relayout", self._on_relayout)
        page.zoomable.append(self)

    @property
    def span(self) -> Span:
        """Time that is shown [s]."""
        start, end = self._full_span()
        zoomed = self._page.session.display.spans.get(self.recording())
        # Of a long recording in parts, one may be zoomed to where another one has nothing.
        return zoomed if zoomed and zoomed[0] < end and zoomed[1] > start else (start, end)

    @property
    def is_whole(self) -> bool:
        """Whether all of the time is shown."""
        return self.span == self._full_span()

    def show(self) -> None:
        """Draw it again."""
        self._page.update_figure(self.plot, self._make_figure(self.span))

    def _on_relayout(self, event: events.GenericEventArguments) -> None:
        changes = event.args if isinstance(event.args, dict) else {}
        for axis in {name.partition(".")[0] for name in changes if name.startswith("xaxis")}:
            if changes.get(f"{axis}.autorange"):
                self._page.zoom(self.recording(), None)
                return
            ends = changes.get(f"{axis}.range[0]"), changes.get(f"{axis}.range[1]")
            if isinstance(ends[0], int | float) and isinstance(ends[1], int | float) and ends[1] > ends[0]:
                self._page.zoom(self.recording(), (float(ends[0]), float(ends[1])))
                return


def _show_busy(button: ui.button, busy: bool) -> None:
    if not button.is_deleted:
        button.props(**{"add" if busy else "remove": "loading"})


async def in_background(action: Callable[..., Result], *arguments: Any) -> Result | None:
    """Call `action` while the page goes on; None where it fails, which is shown, or the page is being closed.

    What takes longer than `_PATIENCE` says so, and can be cancelled.
    """
    running, client, started = Cancellable(), ui.context.client, time.monotonic()
    result = asyncio.ensure_future(background.io_bound(running.call, action, *arguments))
    await asyncio.wait({result}, timeout=_PATIENCE)
    if not result.done():
        with client, ui.row().classes("notice").props("role=status") as notice:
            ui.spinner(color="white")
            text = ui.label()
            set_test_id(ui.button("Cancel", on_click=running.cancel), "cancel-program").props(
                "flat dense color=white"
            )
        while not result.done():
            text.text = f"{running.text} … {time.monotonic() - started:.0f} s"
            await asyncio.wait({result}, timeout=1.0)
        if not notice.is_deleted:  # as everything on a page that was closed
            notice.delete()
    try:
        return result.result()
    except (BadInput, OSError, TimeoutExpired) as error:
        with client:  # the part with the button may have been drawn again
            notify(str(error), "warning")
        return None


def draw_code(text: str, test_id: str, language: str | None = "bash") -> None:
    """Draw commands for a terminal, or what one prints, with a button that copies it."""
    code = set_test_id(ui.code(text, language=language).classes("w-full"), test_id)
    if language:
        code.classes("command")  # all of it is seen beside the button
    code.copy_button.props('aria-label="Copy this"')
    code.markdown.props("tabindex=0")


def draw_table(
    titles: Sequence[str], rows: Iterable[Sequence[Cell]], words: Collection[int] = (), classes: str = ""
) -> None:
    """Draw a table; the columns `words` are aligned to the left."""
    with ui.element("div").classes("scroll-x").props("tabindex=0"), ui.element("table").classes(f"figures {classes}"):
        for tag, cells in [("th", titles), *(("td", row) for row in rows)]:
            with ui.element("tr"):
                for column, cell in enumerate(cells):
                    with ui.element(tag).classes("words" if column in words else ""):
                        (partial(ui.label, cell) if isinstance(cell, str) else cell)()


def say_what_comes(page: Page, what: str) -> None:
    """Say `what` happens here with an analysed model, where there is none."""
    say_what_to_do(page, f"{what} here when the model has been analysed.")


def say_what_to_do(page: Page, then: str) -> None:
    """Say what comes before `then`: a fit of the base model, which may be going on."""
    selection = page.session.selection
    first = "The base model is being fitted. " if selection.is_fitting else "Press Fit. "
    quiet(f"{'' if selection.steps else first}{then}")


def draw_result(table: ResultTable) -> None:
    """Draw a table of results with its caption."""
    draw_table(table.head, table.rows, table.words)
    if table.caption:
        quiet(table.caption)


def quiet(text: str) -> ui.label:
    """Draw a text that explains."""
    return ui.label(text).classes("quiet")


def heading(text: str, classes: str = "") -> ui.label:
    """Draw a heading of a part of a tab."""
    return ui.label(text).classes(f"head {classes}").props("role=heading aria-level=2")


def notify(text: str, kind: Literal["positive", "warning", "info"]) -> None:
    """Show `text` for a while."""
    ui.notify(without_options(text), type=kind, position="bottom", timeout=8000, close_button=True)


def set_test_id(element: Element, test_id: str) -> Element:
    """Give `element` an identifier for tests, and return it."""
    element.props["data-test"] = test_id
    return element
