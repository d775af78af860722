"""A plot over time whose detail is loaded anew with every zoom."""

from collections.abc import Callable

from nicegui import events

from ident.workbench import plots
from ident.workbench.pages.page import picture
from ident.workbench.plots import Figure, Span


class Zoomed:
    """Shows `make(span)`; `whole` is the span of all there is."""

    def __init__(self, make: Callable[[Span], Figure], whole: Callable[[], Span], label: str, dark: bool) -> None:
        self._make, self._whole, self._dark = make, whole, dark
        self.span = whole()
        self.plot = picture(make(self.span), label, dark)
        self.plot.on("plotly_relayout", self._moved)

    def show(self, span: Span | None = None) -> None:
        """This span, or the one that is shown, made anew."""
        self.span = span or self.span
        self.plot.update_figure(plots.shown(self._make(self.span), self._dark))

    def _moved(self, event: events.GenericEventArguments) -> None:
        moved = event.args if isinstance(event.args, dict) else {}
        for axis in ("xaxis", "xaxis2"):
            if moved.get(f"{axis}.autorange"):
                self.show(self._whole())
                return
            ends = moved.get(f"{axis}.range[0]"), moved.get(f"{axis}.range[1]")
            if isinstance(ends[0], int | float) and isinstance(ends[1], int | float) and ends[1] > ends[0]:
                self.show((float(ends[0]), float(ends[1])))
                return
