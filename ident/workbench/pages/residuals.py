"""Residual analysis of the current model, as in `ident compare`."""

from functools import partial

from nicegui import ui

from ident.residuals.phases import Window
from ident.workbench.pages.page import Page, draw_table, heading, say_what_comes, set_test_id


def draw(page: Page) -> None:
    """Draw the sentences, the worst intervals and the figures."""
    view = page.session.selection.analysis.residuals
    if view is None:
        say_what_comes(page, "Where the model fails is shown")
        return
    heading(f"On {', '.join(view.recordings)}")
    with ui.column().classes("gap-1"):
        for index, sentence in enumerate(view.sentences):
            set_test_id(ui.label(sentence), f"residuals-{index}")
    heading("Worst intervals")
    table = view.window_table
    rows = zip(table.rows, view.windows, strict=True)
    draw_table((*table.head, ""), [(*row, partial(_draw_button, page, window)) for row, window in rows], table.words)
    for title, figure in view.figures.items():
        heading(title, "q-mt-md")
        page.draw_figure(figure, title)


def _draw_button(page: Page, window: Window) -> None:
    """Draw a button that shows the interval on the tab Model."""

    def show() -> None:
        display = page.session.display
        display.joint = window.joint - 1
        display.requested_span = (window.recording, window.start - 0.5, window.end + 0.5)
        page.show_tab("model")

    ui.button("show", on_click=show).props("flat dense")
