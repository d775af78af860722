"""A recording before any fit: metadata, quality and signals."""

from nicegui import ui

from ident.workbench.pages import plots
from ident.workbench.pages.page import Page, ZoomablePlot, heading, quiet, set_test_id


def draw(page: Page) -> None:
    """Draw the selected recording."""
    recordings = page.session.recordings
    view = recordings.shown
    if view is None:
        quiet("Choose a recording with Train in the list to see its quality, or drop a file there.")
        return
    with ui.row().classes("items-center gap-3"):
        heading(view.name)
        for name in (recordings.train, recordings.validate):
            if name and name != view.name:
                page.button(f"show {name}", "show-recording", recordings.show, name, props="flat dense")
    for warning in view.warnings:
        with ui.row().classes("items-center no-wrap"):
            ui.icon("warning", color="warning")
            ui.label(warning)
    with ui.element("div").classes("quality"):
        for label, value in view.quality.items():
            quiet(label)
            set_test_id(ui.label(value), f"quality-{label.lower().replace(' ', '-')}")
    signal = ui.toggle(list(view.signals), value="position").props("dense").classes("q-mt-sm")
    plot = ZoomablePlot(
        page,
        lambda span: plots.signal(view, str(signal.value), span),
        lambda: (float(view.time[0]), float(view.time[-1])),
        "signals over time",
    )
    signal.on_value_change(lambda: plot.show())
    with ui.expansion(f"Events of the run ({len(view.events)})").classes("w-full"):
        for time, level, source, text in view.events[:300]:
            ui.label(f"{time:9.3f} s  {level}  {source}: {text}").classes("font-mono text-sm")
