"""A recording before any fit: metadata, quality and signals."""

import shlex
from collections.abc import Awaitable
from pathlib import Path

from nicegui import ui

from ident.output.figures import time_plots
from ident.workbench.figure import Figure, to_dict
from ident.workbench.folder import SUFFIX
from ident.workbench.pages.forms import name_fields
from ident.workbench.pages.page import Page, ZoomablePlot, heading, in_background, quiet, set_test_id
from ident.workbench.programs import file_import
from ident.workbench.programs.file_import import EXCLUDE, KEEP, NEGATE, SWAP, UNIT
from ident.workbench.worker.views import RecordingView
from recordings.data_problems import DataProblem
from recordings.errors import BadInput


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

    def figure(span: time_plots.Span) -> Figure:
        name = str(signal.value)
        return to_dict(time_plots.signal(name, view.signals[name][0], view.time, view.signals[name][1], span))

    plot = ZoomablePlot(
        page,
        lambda: view.name,
        figure,
        lambda: (float(view.time[0]), float(view.time[-1])),
        "signals over time",
    )
    signal.on_value_change(lambda: plot.show())
    if view.columns:
        _Preparation(page, view, plot)
    with ui.expansion(f"Events of the run ({len(view.events)})").classes("w-full"):
        for time, level, source, text in view.events[:300]:
            ui.label(f"{time:9.3f} s  {level}  {source}: {text}").classes("font-mono text-sm")


def _draw_problem(page: Page, recording: str, problem: DataProblem) -> None:
    """Draw what cannot be right about a recording, and the button that heals it, or what to do instead."""
    with ui.row().classes("items-center no-wrap"):
        ui.icon("error" if problem.blocks else "warning", color="negative" if problem.blocks else "warning")
        set_test_id(ui.label(f"{problem.kind}: {problem.why}"), f"problem-{problem.kind}")
        if problem.command:
            heal = (_heal, page, recording, problem.command[1:])
            page.button("write a healed recording", f"heal-{problem.kind}", *heal, props="flat dense no-wrap")
    quiet(problem.remedy)


async def _heal(page: Page, recording: str, words: list[str]) -> None:
    """Run `daq` with `words`, and take the recording that it writes in place of the other one."""
    session = page.session
    if await in_background(file_import.convert, session.folder.root, words) is None:
        return
    healed = Path(words[words.index("--out") + 1]).name
    session.changes.mark("folder")
    pair = (session.recordings.train, session.recordings.validate)
    others = (healed if name == recording else name for name in pair)
    page.discard(
        f"Taking {healed} in place of {recording} discards the models so far", lambda: session.choose(*others)
    )


class _Preparation:
    """What can be changed about a recording of our own, and the command that writes the changed one."""

    def __init__(self, page: Page, view: RecordingView, plot: ZoomablePlot) -> None:
        self._page, self._view, self._plot = page, view, plot
        joints = [int(name.rpartition("_")[2]) for name in view.columns if name.startswith("position_")]
        quantities = [name for name in ("position", "effort", "voltage") if f"{name}_1" in view.columns]
        with set_test_id(ui.expansion("Prepare: trim, exclude, negate, swap, unit").classes("w-full"), "prepare-box"):
            with ui.row().classes("items-center gap-2"):
                self._what = ui.select([KEEP, EXCLUDE, NEGATE, SWAP, UNIT], value=KEEP, label="what")
                self._quantity = ui.select(quantities, value=quantities[0], label="of")
                self._joint = ui.select(
                    {0: "all joints", **{j: f"joint {j}" for j in joints}}, value=0, label="joint"
                )
                self._other = ui.input("unit, or joint to swap with")
                page.button("Write", "prepare", self._write, props="unelevated")
            fields = {"what": self._what, "quantity": self._quantity, "joint": self._joint, "other": self._other}
            name_fields("prepare", **fields)
            self._text = set_test_id(ui.label().classes("font-mono text-sm"), "prepare-command")
        self._joints = joints
        for field in fields.values():
            field.on_value_change(self._show)
        plot.plot.on("plotly_relayout", self._show)
        self._show()

    def _words(self) -> list[str]:
        joints = [self._joint.value] if self._joint.value else self._joints
        what, other = str(self._what.value), str(self._other.value or "").strip()
        if what in (KEEP, EXCLUDE) and self._plot.is_whole:
            raise BadInput("a part of the time expected, all of it shown; zoom into the plot above")
        if what == SWAP and (len(joints) > 1 or other not in map(str, set(self._joints) - set(joints))):
            raise BadInput("one joint, and the number of another one to swap with, expected; choose both")
        if what == UNIT and not other:
            raise BadInput("the unit in which the numbers are expected, none found; write one, such as deg")
        out = self._page.session.folder.free_name(f"{Path(self._view.name).stem}-prepared", SUFFIX)
        options = file_import.preparation(
            self._view.columns, what, self._plot.span, str(self._quantity.value), joints, other
        )
        return ["import", self._view.name, "--out", out, *options]

    def _show(self) -> None:
        moved = self._what.value in (KEEP, EXCLUDE)
        self._quantity.visible = self._joint.visible = not moved
        self._other.visible = self._what.value in (SWAP, UNIT)
        try:
            self._text.text = shlex.join(["daq", *self._words()])
        except BadInput as error:
            self._text.text = str(error)

    def _write(self) -> Awaitable[None]:
        return _heal(self._page, self._view.name, self._words())
