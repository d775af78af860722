"""Time plot that loads its points again at every zoom."""

from collections.abc import Callable

from nicegui import events

from ident.workbench.pages.page import Page
from ident.workbench.plots import Figure, Span


class ZoomablePlot:
    """Shows `make_figure(span)`; `full_span` returns the span of the whole recording."""

    def __init__(
        self, page: Page, make_figure: Callable[[Span], Figure], full_span: Callable[[], Span], label: str
    ) -> None:
        self._page, self._make_figure, self._full_span = page, make_figure, full_span
        self.span = full_span()
        self.plot = page.draw_figure(make_figure(self.span), label)
        self.plot.on("plotly_relayout", self._on_relayout)

    def show(self, span: Span | None = None) -> None:
        """Draw this span, or draw the current span again."""
        self.span = span or self.span
        self._page.update_figure(self.plot, self._make_figure(self.span))

    def _on_relayout(self, event: events.GenericEventArguments) -> None:
        changes = event.args if isinstance(event.args, dict) else {}
        for axis in ("xaxis", "xaxis2"):
            if changes.get(f"{axis}.autorange"):
                self.show(self._full_span())
                return
            ends = changes.get(f"{axis}.range[0]"), changes.get(f"{axis}.range[1]")
            if isinstance(ends[0], int | float) and isinstance(ends[1], int | float) and ends[1] > ends[0]:
                self.show((float(ends[0]), float(ends[1])))
                return
