"""Measured and computed torque of each joint, their residual, and the description of a selected time span."""

from collections.abc import Sequence

from nicegui import events, ui

from ident.workbench import plots
from ident.workbench.pages.candidates import add_button
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.pages.zoom import ZoomablePlot
from ident.workbench.plots import Span
from ident.workbench.time_span import MIN_SHARE, describe_span, explain_gaps, rank_effects, summary
from ident.workbench.views import TorqueSeries

_MAX_EFFECTS = 4
"""Effects listed for a time span, at most."""
_HINT = "Drag over the plot to zoom, double-click to show everything. Select a time span to have it described."
_SELECTED_RANGE_JS = "(event) => emit(event && event.range ? {range: {x: event.range.x || event.range.x2}} : {})"
"""Sends only the range of the selection, not its many points."""


def draw(page: Page) -> None:
    """Draw the current model on all recordings."""
    display, all_series, step_list = (
        page.session.display,
        page.session.selection.series,
        page.session.selection.step_list,
    )
    if not all_series or step_list is None:
        ui.label("Press Fit to see the torque of the base model.").classes("quiet")
        return
    requested_span, display.requested_span = display.requested_span, None
    with ui.row().classes("items-center gap-4"):
        recording = (
            ui.select(
                {number: _label(item, all_series) for number, item in enumerate(all_series)},
                value=_initial_series(all_series, requested_span),
            )
            .props("dense outlined")
            .classes("min-w-64")
        )
        joint = ui.toggle({i: f"joint {i + 1}" for i in range(len(step_list.units))}, value=display.joint).props(
            "dense"
        )
        select = set_test_id(ui.switch("select a time span"), "mark")

    def series() -> TorqueSeries:
        return all_series[int(recording.value or 0)]

    def full_span() -> Span:
        return float(series().time[0]), float(series().time[-1])

    plot = ZoomablePlot(
        page,
        lambda span: plots.torque_comparison(
            series(), joint.value, step_list.units[joint.value], step_list.noise_rms[joint.value], span, select.value
        ),
        full_span,
        "torque measured and computed, and residual, over time",
    )
    gaps = set_test_id(ui.label(explain_gaps(series(), display.joint)).classes("quiet"), "gaps")
    description = set_test_id(ui.column().classes("gap-1"), "selection")
    with description:
        ui.label(_HINT)

    def on_joint() -> None:
        display.joint = joint.value
        description.clear()
        gaps.text = explain_gaps(series(), display.joint)
        plot.show()

    def on_recording() -> None:
        gaps.text = explain_gaps(series(), display.joint)
        plot.show(full_span())

    def on_select(event: events.GenericEventArguments) -> None:
        span = (event.args or {}).get("range", {}).get("x")
        if span:
            units = step_list.units[joint.value], step_list.position_units[joint.value]
            description.clear()
            with description:
                for sentence in describe_span(series(), joint.value, min(span), max(span), *units):
                    ui.label(sentence)
                _show_ranking(page, int(recording.value or 0), joint.value, (min(span), max(span)))

    joint.on_value_change(on_joint)
    recording.on_value_change(on_recording)
    select.on_value_change(lambda: plot.show())
    plot.plot.on("plotly_selected", on_select, js_handler=_SELECTED_RANGE_JS)
    if requested_span:
        plot.show(requested_span[1:])


def _show_ranking(page: Page, number: int, joint: int, span: Span) -> None:
    """Show the effects that would explain the selected span of the series `number`."""
    selection = page.session.selection
    if selection.previews is None:
        ui.label("The effects are still being rated; select again in a moment to see which one explains it.")
        return
    contributions = {effect: arrays[number] for effect, arrays in selection.previews.contributions.items()}
    shares = rank_effects(selection.series[number], contributions, joint, *span)
    set_test_id(ui.label(summary(shares)), "explained")
    for effect, share in list(shares.items())[:_MAX_EFFECTS]:
        if share >= MIN_SHARE:
            with ui.row().classes("items-center gap-3"):
                set_test_id(ui.label(f"{effect}: {100 * share:.0f} % of its mean square"), f"explains-{effect}")
                add_button(page, effect)


def _initial_series(series: Sequence[TorqueSeries], requested_span: tuple[str, float, float] | None) -> int:
    """Return the index of the series with the requested span, or of the first held-out series."""
    if requested_span:
        name, start, end = requested_span
        inside = (
            i for i, item in enumerate(series) if item.name == name and item.time[0] < end and item.time[-1] > start
        )
        return next(inside, 0)
    return next((i for i, item in enumerate(series) if item.held_out), 0)


def _label(item: TorqueSeries, series: Sequence[TorqueSeries]) -> str:
    several = sum(candidate.name == item.name for candidate in series) > 1
    span = f", {item.time[0]:.0f} to {item.time[-1]:.0f} s" if several else ""
    return f"{item.name}{span} ({'held out' if item.held_out else 'training'})"
