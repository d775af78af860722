"""Measured and computed torque of each joint, their residual, and the description of a selected time span."""

from collections.abc import Mapping, Sequence

import numpy as np
from nicegui import events, ui

from ident.workbench.figure import Figure
from ident.workbench.pages import plots
from ident.workbench.pages.candidates import add_button
from ident.workbench.pages.page import Page, ZoomablePlot, quiet, say_what_to_do, set_test_id
from ident.workbench.pages.plots import Span
from ident.workbench.worker.views import Float32s, StepsView, TorqueSeries
from recordings.recording import Bools, Floats

_MAX_EFFECTS = 4
"""Effects listed for a time span, at most."""
_MIN_ROWS = 5
"""Smallest number of rows in a span that is described."""
_NOTABLE_RATIO = 1.5
_MIN_SHARE = 0.1
"""Smallest share of the span's mean square that counts as explained."""
_HINT = "Drag over the plot to zoom, double-click to show everything. Select a time span to have it described."
_SELECTED_RANGE_JS = "(event) => emit(event && event.range ? {range: {x: event.range.x || event.range.x2}} : {})"
"""Sends only the range of the selection, not its many points."""


def draw(page: Page) -> None:
    """Draw the current model on all recordings."""
    all_series, step_list = page.session.selection.analysis.series, page.session.selection.step_list
    if all_series and step_list is not None:
        _TorquePlot(page, all_series, step_list)
    else:
        say_what_to_do(page, "The torque of the base model is shown here.")


class _TorquePlot:
    """The plot of one joint in one recording, which the user chooses, and what is said about a selected span."""

    def __init__(self, page: Page, all_series: Sequence[TorqueSeries], step_list: StepsView) -> None:
        self._page, self._all, self._steps, self._display = page, all_series, step_list, page.session.display
        requested_span, self._display.requested_span = self._display.requested_span, None
        with ui.row().classes("items-center gap-4"):
            names = {number: _label(item, all_series) for number, item in enumerate(all_series)}
            initial = _initial_series(all_series, requested_span, self._display.series)
            self._recording = ui.select(names, value=initial)
            self._recording.props("dense outlined").classes("min-w-64")
            joints = {i: f"joint {i + 1}" for i in range(len(step_list.units))}
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
        return plots.torque_comparison(self._series, joint, unit, noise, span, self._select.value, below)

    def _names(self) -> list[str]:
        shown = self._page.session.recordings.shown
        return list(
            dict.fromkeys(["position", "velocity", *(shown.signals if shown else ()), *self._display.signals])
        )

    def _below(self, name: str) -> plots.Signal:
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
        if share >= _MIN_SHARE:
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


def describe_span(
    series: TorqueSeries, joint: int, start: float, end: float, unit: str = "N m", angle: str = "rad"
) -> tuple[str, ...]:
    """Describe `joint` (from 0) between `start` and `end` [s]; `unit` of effort, `angle` of position."""
    residual = series.residual[:, joint]
    valid = np.isfinite(residual)
    inside = (series.time >= start) & (series.time <= end) & valid
    if inside.sum() < _MIN_ROWS or not (valid & ~inside).any():
        return ("The selection is too short, or covers everything; select a part of the residual.",)
    rms_inside, rms_outside = _rms(residual[inside]), _rms(residual[valid & ~inside])
    return (
        f"{start:.2f} to {end:.2f} s, joint {joint + 1}: residual {rms_inside:.3g} {unit} RMS, "
        f"{rms_inside / rms_outside:.1f} times the residual elsewhere; "
        f"mean {float(residual[inside].mean()):+.3g} {unit}.",
        _motion_sentence(series, joint, inside, valid, angle),
        _phase_sentence(series, joint, inside, valid),
    )


def explain_gaps(series: TorqueSeries, joint: int) -> str:
    """Say which rows of `joint` (from 0) have no residual, and why; empty if all have one."""
    missing = ~np.isfinite(series.residual[:, joint])
    outside = missing & (series.cycle == 0) & bool((series.cycle > 0).any())
    lost = missing & ~outside & ~np.isfinite(series.measured[:, joint])
    reasons = {
        "outside of the repeated motion": outside,
        "lost, or too close to the ends to be filtered": lost,
        "at standstill, where friction has no direction, near saturation, or kept apart for the test": missing
        & ~lost
        & ~outside,
    }
    parts = [f"{rows.mean():.0%} {reason}" for reason, rows in reasons.items() if rows.any()]
    return f"Gaps in the residual are rows that are not scored: {'; '.join(parts)}." if parts else ""


def rank_effects(
    series: TorqueSeries, contributions: Mapping[str, Float32s], joint: int, start: float, end: float
) -> dict[str, float]:
    """Return the share of the residual of `joint` (from 0) between `start` and `end` [s] that each effect explains.

    contributions: (m, dof) by effect, with coefficients fitted to all rows. An effect that would explain the span
    only at the expense of the rest therefore ranks low. The result is in descending order of the share of the
    residual's mean square, which is negative if the effect increases it; empty for a span that is too short.
    """
    residual = series.residual[:, joint]
    inside = (series.time >= start) & (series.time <= end) & np.isfinite(residual)
    if inside.sum() < _MIN_ROWS:
        return {}
    total = _rms(residual[inside])
    shares = {}
    for effect, torque in contributions.items():
        remaining = _rms(residual[inside] - np.nan_to_num(torque[inside, joint].astype(float)))
        shares[effect] = 1 - (remaining / total) ** 2 if total else 0.0
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


def summary(shares: Mapping[str, float]) -> str:
    """Return the heading of the ranking."""
    if not shares:
        return "The selection is too short to say what explains it."
    best, share = next(iter(shares.items()))
    if share >= _MIN_SHARE:
        return "Effects that would explain this selection, with coefficients fitted to the whole recording:"
    return (
        f"No effect of the library explains this selection: {best} explains most, {100 * max(share, 0.0):.0f} % of "
        "its mean square."
    )


def _motion_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools, angle: str) -> str:
    speed, position = np.abs(series.velocity[:, joint]), series.position[:, joint]
    here, typical = float(np.median(speed[inside])), float(np.median(speed[valid]))
    comparison = (
        "slower than"
        if here * _NOTABLE_RATIO < typical
        else "faster than"
        if here > _NOTABLE_RATIO * typical
        else "as"
    )
    low, high = (float(np.quantile(position[inside], q)) for q in (0.02, 0.98))
    return (
        f"Speed {here:.2g} {angle}/s median, {comparison} usual ({typical:.2g} {angle}/s); position {low:.2f} to "
        f"{high:.2f} {angle} of {float(position[valid].min()):.2f} to {float(position[valid].max()):.2f} {angle}."
    )


def _phase_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools) -> str:
    phase = series.phase[:, joint]
    names = [str(name) for name in np.unique(phase[inside])]
    shares = {name: float((phase[inside] == name).mean()) for name in names}
    usual = {name: float((phase[valid] == name).mean()) for name in names}
    most = sorted(names, key=lambda name: -shares[name])
    text = ", ".join(f"{name} {100 * shares[name]:.0f} % (usually {100 * usual[name]:.0f} %)" for name in most)
    cycles = [int(cycle) for cycle in np.unique(series.cycle[inside]) if cycle > 0]
    return f"Motion phases: {text}." + (f" Cycle {', '.join(map(str, cycles))}." if cycles else "")


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))
