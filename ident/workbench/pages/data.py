"""A recording before any fit: metadata, quality and signals."""

from functools import partial
from pathlib import Path

from nicegui import ui

from ident.workbench.pages import plots
from ident.workbench.pages.page import Page, ZoomablePlot, heading, in_background, quiet, set_test_id
from ident.workbench.programs import file_import
from recordings.data_problems import DataProblem


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
    for problem in view.problems:
        _draw_problem(page, view.name, problem)
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


def _draw_problem(page: Page, recording: str, problem: DataProblem) -> None:
    """Draw what cannot be right about a recording, and the button that heals it, or what to do instead."""
    with ui.row().classes("items-center no-wrap"):
        ui.icon("error" if problem.blocks else "warning", color="negative" if problem.blocks else "warning")
        set_test_id(ui.label(f"{problem.kind}: {problem.why}"), f"problem-{problem.kind}")
        if problem.command:
            heal = partial(_heal, page, recording, problem.command[1:])
            button = ui.button("write a healed recording", on_click=heal)
            set_test_id(button, f"heal-{problem.kind}").props("flat dense no-wrap")
    quiet(problem.remedy)


async def _heal(page: Page, recording: str, words: list[str]) -> None:
    """Run `daq` with `words`, and take the healed recording in place of the other one."""
    session = page.session
    if await in_background(file_import.convert, session.folder.root, words) is None:
        return
    healed = Path(words[words.index("--out") + 1]).name
    session.changes.mark("folder")
    chosen = session.recordings
    session.choose(*(healed if name == recording else name for name in (chosen.train, chosen.validate)))
