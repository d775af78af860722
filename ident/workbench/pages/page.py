"""Shared by all parts of the page: redrawing after changes, and error notifications."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from ident.workbench import plots
from ident.workbench.plots import Figure
from ident.workbench.session import WorkbenchSession
from ident.workbench.topics import Topic
from recordings.errors import BadInput


@dataclass
class _Watch:
    callback: Callable[[], None]
    topics: tuple[Topic, ...]
    min_interval: float
    version: int
    last_call: float = 0.0


class Page:
    """One browser tab that shows the session."""

    def __init__(self, session: WorkbenchSession) -> None:
        self.session = session
        self.show_tab: Callable[[str], None] = lambda tab: None
        """Show a tab of the page."""
        self.after_action: Callable[[], None] = lambda: None
        """Update the header at once, because the server ignores clicks on buttons that it believes to be hidden."""
        self._watches: list[_Watch] = []

    def draw_on_change(self, draw: Callable[[], None], *topics: Topic) -> ui.element:
        """Call `draw` here, and again whenever one of `topics` changes; return the container of its elements."""
        with ui.element("div").classes("w-full") as container:

            def redraw() -> None:
                container.clear()
                with container:
                    draw()

            draw()
        self.call_on_change(redraw, *topics)
        return container

    def call_on_change(self, callback: Callable[[], None], *topics: Topic, min_interval: float = 0.0) -> None:
        """Call `callback` whenever one of `topics` changes, but not again within `min_interval` [s]."""
        self._watches.append(_Watch(callback, topics, min_interval, self._version(topics)))

    def poll(self) -> None:
        """Redraw what has changed since the last call."""
        self.session.mark_seen()
        now = time.monotonic()
        for watch in self._watches:
            version = self._version(watch.topics)
            if version != watch.version and now - watch.last_call >= watch.min_interval:
                watch.version, watch.last_call = version, now
                watch.callback()

    def handler(self, action: Callable[..., Any], *arguments: Any) -> Callable[[], None]:
        """Return an event handler that calls `action` and shows its errors."""

        def handle() -> None:
            try:
                action(*arguments)
            except (BadInput, OSError) as error:
                ui.notify(str(error), type="warning", position="bottom", timeout=8000, close_button=True)
            self.after_action()

        return handle

    def _version(self, topics: tuple[Topic, ...]) -> int:
        return sum(self.session.versions[topic] for topic in topics)


def draw_figure(figure: Figure, label: str, dark: bool) -> ui.plotly:
    """Draw a figure; `label` is its description for screen readers."""
    plot = ui.plotly(plots.with_theme(figure, dark)).classes("w-full")
    # Plotly forgets a figure's own height when its tab is left and shown again.
    plot.style(f"height: {figure['layout']['height']}px")
    plot.props["role"], plot.props["aria-label"] = "img", label
    return plot


def set_test_id(element: ui.element, test_id: str) -> None:
    """Give `element` an identifier for tests."""
    element.props["data-test"] = test_id
