"""Figures of the page of a fleet: robots over time at a glance, and the trends of one robot."""

from collections import defaultdict
from collections.abc import Sequence
from datetime import datetime

import numpy as np
import plotly.graph_objects as go

from ident.fleet.alarms import Alarm
from ident.fleet.change_screening import base_name
from ident.fleet.series import Nights, Series, moment
from ident.output.figures import theme

_ROW = 22
"""Height of a robot [px]."""
_PLOT = 190
"""Height of a row of trends [px]."""
STATES = ("cannot be used", "as before", "changed, acknowledged", "changed")
_COLOURS = (theme.MEASURED, theme.NOISE, theme.CATEGORIES[1], theme.CATEGORIES[2])
_MOTION_SYMBOLS = theme.SYMBOLS


def glance(nights: Sequence[Nights], failed: Sequence[tuple[str, datetime]], alarms: Sequence[Alarm]) -> go.Figure:
    """Robots over time, each recording coloured by its verdict. failed: robot and start, where these are known."""
    robots = sorted({*(each.robot for each in nights), *(robot for robot, _ in failed)})
    figure = theme.subplots(1, 1, theme.LEGEND + theme.FOOTER + _ROW * max(len(robots), 3))
    points: dict[int, list[tuple[datetime, str]]] = defaultdict(list)
    points[0] = [(start, robot) for robot, start in failed]
    for each in nights:
        for start in map(moment, each.day):
            points[_state(each.robot, start, alarms)].append((start, each.robot))
    for state, (label, colour) in enumerate(zip(STATES, _COLOURS, strict=True)):
        if points[state]:
            starts, names = zip(*sorted(points[state]), strict=True)
            figure.add_scatter(
                x=starts,
                y=[theme.escaped(name) for name in names],
                mode="markers",
                name=label,
                marker={"symbol": "square" if state else "x", "size": 11, "color": colour},
                hovertemplate="%{y}, %{x|%Y-%m-%d %H:%M}",
            )
    figure.update_yaxes(categoryorder="array", categoryarray=[theme.escaped(robot) for robot in robots[::-1]])
    figure.update_yaxes(range=[-0.6, len(robots) - 0.4])
    return figure


def trends(series: Sequence[Series], floors: Sequence[Series], alarms: Sequence[Alarm]) -> go.Figure:
    """Series of one robot over time, those of all joints in one plot, with the dates of its `alarms`.

    floors: noise floors, which are drawn beside the errors.
    """
    groups: dict[str, list[Series]] = defaultdict(list)
    for each in series:
        groups[base_name(each.name)].append(each)
    columns = 2 if len(groups) > 1 else 1
    rows = -(-len(groups) // columns)
    titles = [f"{name.rstrip('_')} [{of_group[0].unit}]" for name, of_group in groups.items()]
    figure = theme.subplots(
        rows,
        columns,
        theme.HEADER + theme.FOOTER + _PLOT * rows,
        subplot_titles=titles,
        vertical_spacing=0.3 / max(rows, 2),
    )
    shown: set[int | None] = set()
    for number, of_group in enumerate(groups.values()):
        place = {"row": number // columns + 1, "col": number % columns + 1}
        for each in of_group:
            figure.add_trace(_trace(each, show_legend=each.joint not in shown), **place)
            shown.add(each.joint)
        for floor in floors if of_group[0].kind == "error" else ():
            line = {"color": theme.NOISE, "width": 1, "dash": "dot"}
            x, y = list(map(moment, floor.nights.day)), floor.value
            figure.add_scatter(x=x, y=y, mode="lines", line=line, showlegend=False, name="noise floor", **place)
        for alarm in alarms:
            _mark(figure, alarm, place)
    return figure


def _state(robot: str, start: datetime, alarms: Sequence[Alarm]) -> int:
    """Index in STATES of a recording that can be used."""
    concerned = [alarm for alarm in alarms if alarm.robot == robot and alarm.since <= str(start.date())]
    if not concerned:
        return 1
    return 2 if all(alarm.acknowledged for alarm in concerned) else 3


def _trace(series: Series, show_legend: bool) -> go.Scatter:
    known = series.known
    colour = theme.CATEGORIES[0] if series.joint is None else theme.joint_colour(series.joint - 1)
    motion = series.nights.motion[known]
    return go.Scatter(
        x=list(map(moment, series.nights.day[known])),
        y=series.value[known],
        error_y={
            "array": np.nan_to_num((series.high - series.low) / 2)[known],
            "thickness": 1,
            "width": 0,
            "color": colour,
        },
        mode="markers",
        name="whole robot" if series.joint is None else f"joint {series.joint}",
        legendgroup=str(series.joint),
        showlegend=show_legend,
        marker={
            "color": colour,
            "size": 6,
            "symbol": [_MOTION_SYMBOLS[number % len(_MOTION_SYMBOLS)] for number in motion],
        },
        hovertemplate="%{x|%Y-%m-%d}: %{y:.4g}",
    )


def _mark(figure: go.Figure, alarm: Alarm, place: dict[str, int]) -> None:
    """A line at the date of an alarm, and a band over its interval."""
    colour = theme.CATEGORIES[1] if alarm.acknowledged else theme.CATEGORIES[2]
    first, last = alarm.since_ci95
    figure.add_vline(x=alarm.since, line={"color": colour, "width": 1}, **place)
    if first != last:
        figure.add_vrect(x0=first, x1=last, fillcolor=colour, opacity=0.12, line_width=0, **place)
