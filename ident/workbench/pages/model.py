"""Torque measured against the model's, joint by joint, what is left of it, and what is special about a part."""

from collections.abc import Sequence

from nicegui import events, ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.pages.zoom import ZoomablePlot
from ident.workbench.selection import MIN_SHARE, rank_effects, describe_span, summary
from ident.workbench.views import TorqueSeries

_MAX_EFFECTS = 4
"""Effects that are offered for a part."""


def draw(page: Page) -> None:
    """The present model on both recordings."""
    page.draw_on_change(lambda: _draw(page), "series")


def _draw(page: Page) -> None:
    session = page.session
    if not session.series or session.ladder is None:
        ui.label("Fit the base model first: What is missing → Fit.").classes("quiet")
        return
    ladder = session.ladder
    kinds = {number: _label(one, session.series) for number, one in enumerate(session.series)}
    wanted, session.requested_span = session.requested_span, None
    chosen = _initial_series(session.series, wanted)
    with ui.row().classes("items-center gap-4"):
        which = ui.select(kinds, value=chosen).props("dense outlined").classes("min-w-64")
        joint = ui.toggle({i: f"joint {i + 1}" for i in range(len(ladder.joints))}, value=session.joint)
        joint.props("dense no-caps")
        mark = ui.switch("mark a part")
        set_test_id(mark, "mark")

    def series() -> TorqueSeries:
        number = int(which.value or 0)
        return session.series[number]

    def whole() -> tuple[float, float]:
        return float(series().time[0]), float(series().time[-1])

    shown = ZoomablePlot(
        lambda span: plots.torque_comparison(
            series(), joint.value, ladder.units[joint.value], ladder.noise_rms[joint.value], span, mark.value
        ),
        whole,
        "torque measured and computed, and residual, over time",
        session.dark,
    )
    told = ui.column().classes("gap-1")
    set_test_id(told, "special")

    def choose() -> None:
        session.joint = joint.value
        told.clear()
        shown.show()

    def marked(event: events.GenericEventArguments) -> None:
        span = (event.args or {}).get("range", {}).get("x")
        if span:
            units = ladder.units[joint.value], ladder.position_units[joint.value]
            _show_sentences(told, describe_span(series(), joint.value, min(span), max(span), *units))
            with told:
                _show_ranking(page, int(which.value or 0), joint.value, (min(span), max(span)))

    joint.on_value_change(choose)
    which.on_value_change(lambda: shown.show(whole()))
    mark.on_value_change(lambda: shown.show())
    shown.plot.on("plotly_selected", marked, js_handler=_SELECTED_RANGE_JS)
    _show_sentences(told, ("Drag over the plot to zoom, double click to see all. Mark a part to see what is special there.",))
    if wanted:
        shown.show(wanted[1:])


_SELECTED_RANGE_JS = "(event) => emit(event && event.range ? {range: {x: event.range.x || event.range.x2}} : {})"
"""The points that were marked are many, and nobody asks for them."""


def _show_ranking(page: Page, number: int, joint: int, span: tuple[float, float]) -> None:
    """Which effects would take the marked part away."""
    session = page.session
    if session.previews is None:
        ui.label("The effects are still being looked at; mark again in a moment to see which explains it.")
        return
    removed = {effect: parts[number] for effect, parts in session.previews.contributions.items()}
    found = rank_effects(session.series[number], removed, joint, *span)
    set_test_id(ui.label(summary(found)), "explained")
    for one in found[:_MAX_EFFECTS]:
        if one.share < MIN_SHARE:
            break
        with ui.row().classes("items-center gap-3"):
            set_test_id(ui.label(f"{one.effect}: {100 * one.share:.0f} % of its mean square"), f"explains-{one.effect}")
            add = ui.button("Add", on_click=page.handler(session.add, one.effect))
            add.props(f'dense size=sm no-caps unelevated aria-label="Add {one.effect}"')
            set_test_id(add, f"add-{one.effect}")


def _initial_series(series: Sequence[TorqueSeries], requested_span: tuple[str, float, float] | None) -> int:
    """Which one is shown first: where the part is that is wanted, or else what was held out."""
    if requested_span:
        name, start, end = requested_span
        inside = (
            i for i, one in enumerate(series) if one.name == name and one.time[0] < end and one.time[-1] > start
        )
        return next(inside, 0)
    return next((i for i, one in enumerate(series) if one.held_out), 0)


def _label(item: TorqueSeries, series: Sequence[TorqueSeries]) -> str:
    several = sum(other.name == item.name for other in series) > 1
    part = f", {item.time[0]:.0f} to {item.time[-1]:.0f} s" if several else ""
    return f"{item.name}{part} ({'held out' if item.held_out else 'training'})"


def _show_sentences(column: ui.column, sentences: tuple[str, ...]) -> None:
    column.clear()
    with column:
        for sentence in sentences:
            ui.label(sentence)
