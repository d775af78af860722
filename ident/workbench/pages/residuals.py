"""Residual analysis of the current model, as in `ident compare`."""

from collections.abc import Callable

from nicegui import ui

from ident.residuals.windows import Window
from ident.workbench.pages.page import Page, draw_figure, set_test_id


def draw(page: Page) -> None:
    """Draw the sentences, the worst intervals and the figures."""
    page.draw_on_change(lambda: _draw(page), "residuals")


def _draw(page: Page) -> None:
    view = page.session.residuals
    if view is None:
        pending = "Analysing the residual …" if page.session.ladder else None
        ui.label(pending or "Fit the base model first (Missing effects → Fit).").classes("quiet")
        return
    ui.label(f"On {', '.join(view.recordings)}").classes("head")
    with ui.column().classes("gap-1"):
        for number, sentence in enumerate(view.sentences):
            set_test_id(ui.label(sentence), f"residuals-{number}")
    ui.label("Worst intervals").classes("head")
    _windows(page)
    for title, figure in view.figures.items():
        ui.label(title).classes("head q-mt-md")
        draw_figure(figure, title, page.session.dark)


def _windows(page: Page) -> None:
    view = page.session.residuals
    assert view is not None
    with ui.element("table").classes("figures"):
        with ui.element("tr"):
            for title in (
                "joint",
                "time [s]",
                f"RMS [{view.unit}]",
                "relative to overall RMS",
                "phase",
                "cycle",
                "",
            ):
                with ui.element("th"):
                    ui.label(title)
        for window in view.windows:
            with ui.element("tr"):
                for text in (
                    f"joint {window.joint}",
                    f"{window.start:.2f} – {window.end:.2f}",
                    f"{window.rms:.3g}",
                    f"{window.times_overall:.1f}",
                    window.phase,
                    str(window.cycle or ""),
                ):
                    with ui.element("td"):
                        ui.label(text)
                with ui.element("td"):
                    ui.button("show", on_click=_show_handler(page, window)).props("flat dense size=sm no-caps")


def _show_handler(page: Page, window: Window) -> Callable[[], None]:
    def show() -> None:
        page.session.joint = window.joint - 1
        page.session.requested_span = (window.recording, window.start - 0.5, window.end + 0.5)
        page.session.mark_changed("series")
        page.show_tab("model")

    return show
