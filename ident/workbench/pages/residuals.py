"""Residual analysis of the current model, as in `ident compare`."""

from nicegui import ui

from ident.output.digits import number
from ident.residuals.windows import Window
from ident.workbench.pages.page import Cell, Page, draw_table, heading, set_test_id


def draw(page: Page) -> None:
    """Draw the sentences, the worst intervals and the figures."""
    view = page.session.selection.residuals
    if view is None:
        ui.label(
            "The residual is shown here when it has been analysed."
            if page.session.selection.step_list
            else "Press Fit to see where the model fails."
        ).classes("quiet")
        return
    heading(f"On {', '.join(view.recordings)}")
    with ui.column().classes("gap-1"):
        for index, sentence in enumerate(view.sentences):
            set_test_id(ui.label(sentence), f"residuals-{index}")
    heading("Worst intervals")
    titles = ("joint", "time [s]", f"RMS [{view.unit}]", "of the joint's RMS", "phase of most error", "cycle", "")
    draw_table(titles, [_row(page, window) for window in view.windows])
    for title, figure in view.figures.items():
        heading(title, "q-mt-md")
        page.draw_figure(figure, title)


def _row(page: Page, window: Window) -> tuple[Cell, ...]:
    return (
        f"joint {window.joint}",
        f"{window.start:.2f} – {window.end:.2f}",
        number(window.rms),
        f"{window.times_overall:.1f} ×",
        window.phase,
        str(window.cycle or ""),
        lambda: ui.button("show", on_click=lambda: _show(page, window)).props("flat dense"),
    )


def _show(page: Page, window: Window) -> None:
    """Show the interval on the tab Model."""
    display = page.session.display
    display.joint = window.joint - 1
    display.requested_span = (window.recording, window.start - 0.5, window.end + 0.5)
    page.session.changes.mark("series")
    page.show_tab("model")
