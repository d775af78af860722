"""Residual analysis of the current model, as in `ident compare`."""

from functools import partial

from nicegui import ui

from ident.residuals.windows import Window
from ident.workbench.pages.page import Page, draw_table, heading, quiet, set_test_id


def draw(page: Page) -> None:
    """Draw the sentences, the worst intervals and the figures."""
    view = page.session.selection.analysis.residuals
    if view is None:
        fitted = page.session.selection.step_list is not None
        quiet(
            "The residual is shown here when it has been analysed."
            if fitted
            else "Press Fit to see where the model fails."
        )
        return
    heading(f"On {', '.join(view.recordings)}")
    with ui.column().classes("gap-1"):
        for index, sentence in enumerate(view.sentences):
            set_test_id(ui.label(sentence), f"residuals-{index}")
    heading("Worst intervals")
    table = view.window_table
    shown = [partial(_draw_button, page, window) for window in view.windows]
    draw_table((*table.head, ""), [(*row, cell) for row, cell in zip(table.rows, shown, strict=True)], table.words)
    for title, figure in view.figures.items():
        heading(title, "q-mt-md")
        page.draw_figure(figure, title)


def _draw_button(page: Page, window: Window) -> None:
    ui.button("show", on_click=lambda: _show(page, window)).props("flat dense")


def _show(page: Page, window: Window) -> None:
    """Show the interval on the tab Model."""
    display = page.session.display
    display.joint = window.joint - 1
    display.requested_span = (window.recording, window.start - 0.5, window.end + 0.5)
    page.session.changes.mark("series")
    page.show_tab("model")
