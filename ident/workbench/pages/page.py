"""What all parts of the page share: drawing again what has changed, and saying what went wrong."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from ident.workbench import plots
from ident.workbench.plots import Figure
from ident.workbench.session import Session
from ident.workbench.topics import Part
from recordings.errors import BadInput


@dataclass
class _Watched:
    react: Callable[[], None]
    parts: tuple[Part, ...]
    pause: float
    seen: int
    last: float = 0.0


class Page:
    """One tab of a browser that looks at the session."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.show: Callable[[str], None] = lambda tab: None
        """Turn to a tab."""
        self.acted: Callable[[], None] = lambda: None
        """Show at once what goes on: the server ignores a click on a button that it believes to be hidden."""
        self._watched: list[_Watched] = []

    def follow(self, draw: Callable[[], None], *parts: Part) -> ui.element:
        """Let `draw` make its elements here, and anew whenever one of `parts` has changed; the place of them."""
        with ui.element("div").classes("w-full") as place:

            def again() -> None:
                place.clear()
                with place:
                    draw()

            draw()
        self.watch(again, *parts)
        return place

    def watch(self, react: Callable[[], None], *parts: Part, pause: float = 0.0) -> None:
        """Call `react` whenever one of `parts` has changed from now on, but not again within `pause` [s]."""
        self._watched.append(_Watched(react, parts, pause, self._version(parts)))

    def poll(self) -> None:
        """Look for changes."""
        self.session.seen()
        now = time.monotonic()
        for one in self._watched:
            version = self._version(one.parts)
            if version != one.seen and now - one.last >= one.pause:
                one.seen, one.last = version, now
                one.react()

    def does(self, act: Callable[..., Any], *arguments: Any) -> Callable[[], None]:
        """A handler that does `act`, and says what was wrong with it."""

        def handle() -> None:
            try:
                act(*arguments)
            except (BadInput, OSError) as error:
                ui.notify(str(error), type="warning", position="bottom", timeout=8000, close_button=True)
            self.acted()

        return handle

    def _version(self, parts: tuple[Part, ...]) -> int:
        return sum(self.session.versions[part] for part in parts)


def picture(figure: Figure, label: str, dark: bool) -> ui.plotly:
    """A figure; `label` for those who do not see it."""
    drawn = ui.plotly(plots.shown(figure, dark)).classes("w-full")
    # Plotly forgets a figure's own height when its tab is left and shown again.
    drawn.style(f"height: {figure['layout']['height']}px")
    drawn.props["role"], drawn.props["aria-label"] = "img", label
    return drawn


def name(element: ui.element, what: str) -> None:
    """A name for tests, beside all that may change."""
    element.props["data-test"] = what
