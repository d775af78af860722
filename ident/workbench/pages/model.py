"""Measured and computed torque of each joint, their residual, and the description of a selected time span."""

from collections.abc import Sequence

import numpy as np
from nicegui import events, ui

from ident.output.figures import time_plots
from ident.output.figures.time_plots import Span
from ident.residuals.time_span import (
    MIN_SHARE,
    TorqueSeries,
    describe_span,
    explain_gaps,
    rank_effects,
    summary,
)
from ident.workbench.figure import Figure, to_dict
from ident.workbench.pages.candidates import add_button
from ident.workbench.pages.page import Page, ZoomablePlot, quiet, say_what_to_do, set_test_id
from ident.workbench.worker.views import StepsView

_MAX_EFFECTS = 4
"""Effects listed for a time span, at most."""
_HINT = "Drag over the plot to zoom, double-click to show everything. Select a time span to have it described."
_SELECTED_RANGE_JS = "(event) => emit(event && event.range ? {range: {x: event.range.x || event.range.x2}} : {})"
"""Sends only the range of the selection, not its many points."""


def draw(page: Page) -> None:
    """Draw the current model on all recordings."""
    all_series, made = page.session.selection.analysis.series, page.session.selection.steps
    if all_series and made is not None:
        _TorquePlot(page, all_series, made)
    else:
        say_what_to_do(page, "The torque of the base model is shown here.")


class _TorquePlot:
    """The plot of one joint in one recording, which the user chooses, and what is said about a selected span."""

    def __init__(self, page: Page, all_series: Sequence[TorqueSeries], made: StepsView) -> None:
        self._page, self._all, self._steps, self._display = page, all_series, made, page.session.display
        requested_span, self._display.requested_span = self._display.requested_span, None
        with ui.row().classes("items-center gap-4"):
            names = {number: _label(item, all_series) for number, item in enumerate(all_series)}
            initial = _initial_series(all_series, requested_span, self._display.series)
            self._recording = ui.select(names, value=initial)
            self._recording.props("dense outlined").classes("min-w-64")
            joints = {i: f"joint {i + 1}" for i in range(len(made.units))}
            self._joint = ui.toggle(joints, value=self._display.joint).props("dense")
            self._select = set_test_id(ui.switch("select a time span"), "mark")
            self._signals = ui.select(
                self._names(), value=self._display.signals, label="signals below", multiple=True
            )
            set_test_id(self._signals, "signals").props("dense outlined use-chips").classes("min-w-48")
        label = "torque measured and computed, and residual, over time"
        if requested_span:
            self._display.spans[requested_span[0]] = requested_span[1:]
        self._plot = ZoomablePlot(page, lambda: self._series.name, self._figure, self._full_span, label)
        self._gaps = set_test_id(quiet(""), "gaps")
        self._explain_gaps()
        self._description = set_test_id(ui.column().classes("gap-1"), "selection")
        with self._description:
            ui.label(_HINT)
        self._joint.on_value_change(self._on_joint)
        self._recording.on_value_change(self._on_recording)
        self._select.on_value_change(lambda: self._plot.show())
        self._signals.on_value_change(self._on_signals)
        self._plot.plot.on("plotly_selected", self._on_select, js_handler=_SELECTED_RANGE_JS)

    @property
    def _series(self) -> TorqueSeries:
        return self._all[int(self._recording.value or 0)]

    def _full_span(self) -> Span:
        return float(self._series.time[0]), float(self._series.time[-1])

    def _figure(self, span: Span) -> Figure:
        joint, steps = self._joint.value, self._steps
        unit, noise = steps.units[joint], steps.noise_rms[joint]
        below = [self._below(name) for name in self._display.signals]
        return to_dict(
            time_plots.torque_comparison(self._series, joint, unit, noise, span, self._select.value, below)
        )

    def _names(self) -> list[str]:
        shown = self._page.session.recordings.shown
        return list(
            dict.fromkeys(["position", "velocity", *(shown.signals if shown else ()), *self._display.signals])
        )

    def _below(self, name: str) -> time_plots.Signal:
        """Return a signal as it was recorded, or the motion that enters the model."""
        series, shown = self._series, self._page.session.recordings.shown
        angle = self._steps.position_units[self._joint.value]
        found = {"position": (angle, series.position), "velocity": (f"{angle}/s", series.velocity)}
        if name in found:
            unit, values = found[name]
            return f"{name}<br>[{unit}]", series.time, values[:, self._joint.value]
        if shown is None or shown.name != series.name:
            return f"{name}<br>is being read", series.time[:1], np.full(1, np.nan)
        unit, raw = shown.signals[name]
        return f"{name}<br>[{unit}]", shown.time, raw[:, min(self._joint.value, raw.shape[1] - 1)]

    def _explain_gaps(self) -> None:
        self._gaps.text = explain_gaps(self._series, self._display.joint)

    def _on_joint(self) -> None:
        self._display.joint = self._joint.value
        self._description.clear()
        self._explain_gaps()
        self._plot.show()

    def _on_recording(self) -> None:
        self._display.series = int(self._recording.value or 0)
        self._explain_gaps()
        self._on_signals()

    def _on_signals(self) -> None:
        """Draw the chosen signals; those that only the recording has follow when it has been read."""
        self._display.signals = list(self._signals.value or ())
        self._plot.show()
        shown, name = self._page.session.recordings.shown, self._series.name
        if not {"position", "velocity"}.issuperset(self._display.signals) and (shown is None or shown.name != name):
            self._page.session.recordings.show(name)

    def _on_select(self, event: events.GenericEventArguments) -> None:
        ends = (event.args or {}).get("range", {}).get("x")
        if not ends:
            return
        span, joint = (min(ends), max(ends)), self._joint.value
        units = self._steps.units[joint], self._steps.position_units[joint]
        self._description.clear()
        with self._description:
            for sentence in describe_span(self._series, joint, *span, *units):
                ui.label(sentence)
            _show_ranking(self._page, int(self._recording.value or 0), joint, span)


def _show_ranking(page: Page, number: int, joint: int, span: Span) -> None:
    """Show the effects that would explain the selected span of the series `number`."""
    analysis = page.session.selection.analysis
    if analysis.previews is None:
        ui.label("The effects are still being rated; select again in a moment to see which one explains it.")
        return
    contributions = {effect: arrays[number] for effect, arrays in analysis.previews.contributions.items()}
    shares = rank_effects(analysis.series[number], contributions, joint, *span)
    set_test_id(ui.label(summary(shares)), "explained")
    for effect, share in list(shares.items())[:_MAX_EFFECTS]:
        if share >= MIN_SHARE:
            with ui.row().classes("items-center gap-3"):
                set_test_id(ui.label(f"{effect}: {100 * share:.0f} % of its mean square"), f"explains-{effect}")
                add_button(page, effect)


def _initial_series(
    series: Sequence[TorqueSeries], requested_span: tuple[str, float, float] | None, before: int | None
) -> int:
    """Return the index of the series with the requested span, of the one `before`, or of the first held-out one."""
    if requested_span:
        name, start, end = requested_span
        inside = (
            i for i, item in enumerate(series) if item.name == name and item.time[0] < end and item.time[-1] > start
        )
        return next(inside, 0)
    if before is not None and before < len(series):
        return before
    return next((i for i, item in enumerate(series) if item.held_out), 0)


def _label(item: TorqueSeries, series: Sequence[TorqueSeries]) -> str:
    several = sum(candidate.name == item.name for candidate in series) > 1
    span = f", {item.time[0]:.0f} to {item.time[-1]:.0f} s" if several else ""
    return f"{item.name}{span} ({'held out' if item.held_out else 'training'})"
