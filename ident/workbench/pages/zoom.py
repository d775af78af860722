"""A plot over time whose detail is loaded anew with every zoom."""

from collections.abc import Callable

from nicegui import events, ui

from ident.workbench.plots import Figure

Span = tuple[float, float]


class Zoomed:
    """Shows `make(span)`; `whole` is the span of all there is."""

    def __init__(self, make: Callable[[Span], Figure], whole: Callable[[], Span], label: str) -> None:
        self._make, self._whole = make, whole
        self.span = whole()
        self.plot = ui.plotly(make(self.span)).classes("w-full").props(f'role=img aria-label="{label}"')
        self.plot.on("plotly_relayout", self._moved)

    def show(self, span: Span | None = None) -> None:
        """This span, or the one that is shown, made anew."""
        self.span = span or self.span
        self.plot.update_figure(self._make(self.span))

    def _moved(self, event: events.GenericEventArguments) -> None:
        moved = event.args if isinstance(event.args, dict) else {}
        if moved.get("xaxis.autorange"):
            self.show(self._whole())
        elif "xaxis.range[0]" in moved and "xaxis.range[1]" in moved:
            start, end = float(moved["xaxis.range[0]"]), float(moved["xaxis.range[1]"])
            if end > start:
                self.show((start, end))
