"""What all parts of the page share: drawing again what has changed, and saying what went wrong."""

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
    """One tab of a browser that looks at the session."""

    def __init__(self, session: WorkbenchSession) -> None:
        self.session = session
        self.show_tab: Callable[[str], None] = lambda tab: None
        """Turn to a tab."""
        self.after_action: Callable[[], None] = lambda: None
        """Show at once what goes on: the server ignores a click on a button that it believes to be hidden."""
        self._watches: list[_Watch] = []

    def draw_on_change(self, draw: Callable[[], None], *topics: Topic) -> ui.element:
        """Let `draw` make its elements here, and anew whenever one of `parts` has changed; the place of them."""
        with ui.element("div").classes("w-full") as place:

            def again() -> None:
                place.clear()
                with place:
                    draw()

            draw()
        self.call_on_change(again, *topics)
        return place

    def call_on_change(self, callback: Callable[[], None], *topics: Topic, min_interval: float = 0.0) -> None:
        """Call `react` whenever one of `parts` has changed from now on, but not again within `pause` [s]."""
        self._watches.append(_Watch(callback, topics, min_interval, self._version(topics)))

    def poll(self) -> None:
        """Look for changes."""
        self.session.mark_seen()
        now = time.monotonic()
        for one in self._watches:
            version = self._version(one.topics)
            if version != one.version and now - one.last_call >= one.min_interval:
                one.version, one.last_call = version, now
                one.callback()

    def handler(self, action: Callable[..., Any], *arguments: Any) -> Callable[[], None]:
        """A handler that does `act`, and says what was wrong with it."""

        def handle() -> None:
            try:
                action(*arguments)
            except (BadInput, OSError) as error:
                ui.notify(str(error), type="warning", position="bottom", timeout=8000, close_button=True)
            self.after_action()

        return handle

    def _version(self, topics: tuple[Topic, ...]) -> int:
        return sum(self.session.versions[part] for part in topics)


def draw_figure(figure: Figure, label: str, dark: bool) -> ui.plotly:
    """A figure; `label` for those who do not see it."""
    drawn = ui.plotly(plots.with_theme(figure, dark)).classes("w-full")
    # Plotly forgets a figure's own height when its tab is left and shown again.
    drawn.style(f"height: {figure['layout']['height']}px")
    drawn.props["role"], drawn.props["aria-label"] = "img", label
    return drawn


def set_test_id(element: ui.element, test_id: str) -> None:
    """A name for tests, beside all that may change."""
    element.props["data-test"] = test_id
