"""Torque measured against computed, and what is left, over time."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.data.dataset import first_cycle
from ident.identification.prediction import Prediction
from ident.output.figures import theme
from ident.residuals.analysis import Comparison
from ident.residuals.windows import Window
from recordings.recording import Floats

AROUND = 0.5
"""Seconds that are drawn before and after a worst stretch."""
COLUMNS = 3
BETWEEN = 84
"""Pixels between rows of plots, for the labels of one and the titles of the next."""


def over_time(models: Mapping[str, Comparison], index: int, points: int = theme.MAX_POINTS) -> go.Figure:
    """Per joint, the torque and below it the residual, in the recording `index` of all comparisons.

    All share one time axis; the first repetition is shown at first, a double click shows the whole. Of each trace
    all of the first repetition is there, and so many `points` of the whole.
    """
    first, *_ = models.values()
    dataset = first.predictions[index].dataset
    dof = len(first.joints)
    figure = theme.subplots(
        2 * dof,
        1,
        theme.LEGEND + theme.FOOTER + 160 * dof,
        shared_xaxes=True,
        row_heights=[2, 1] * dof,
        vertical_spacing=0.08 / dof,
    )
    for joint, about in enumerate(first.joints):
        row = 2 * joint + 1
        time, measured = theme.thinned(dataset.time, dataset.torque[:, joint], points, first_cycle(dataset))
        thick = {"color": theme.MEASURED, "width": 3.5}
        _line(figure, time, measured, row, "measured", joint == 0, thick)
        for number, (name, comparison) in enumerate(models.items()):
            label = theme.escaped(name) if len(models) > 1 else "model"
            _model(figure, comparison.predictions[index], joint, number, label, points)
        theme.noise_band(figure, about.split.noise_rms if about.split else None, row + 1, 1, joint == 0)
        figure.update_yaxes(title_text=f"{theme.joint_title(joint)}<br>{theme.effort_label(about.unit)}", row=row, col=1)
        figure.update_yaxes(title_text=f"residual<br>[{about.unit}]", nticks=4, row=row + 1, col=1)
    shown = dataset.time[first_cycle(dataset)]
    figure.update_xaxes(range=[float(shown[0]), float(shown[-1])])
    figure.update_xaxes(title_text="time [s]", row=2 * dof, col=1)
    figure.update_layout(hovermode="x unified", hoversubplots="axis")
    return figure


def _model(figure: go.Figure, prediction: Prediction, joint: int, number: int, label: str, points: int) -> None:
    dataset = prediction.dataset
    whole = first_cycle(dataset)
    known = np.isfinite(dataset.torque[:, joint])
    line = {"color": theme.joint_colour(joint), "width": 1.5, "dash": theme.DASHES[number % len(theme.DASHES)]}
    computed = np.where(known, prediction.computed[:, joint], np.nan)
    row = 2 * joint + 1
    _line(figure, *theme.thinned(dataset.time, computed, points, whole), row, label, joint == 0, line)
    left = line | {"width": 1.1}
    residual = theme.thinned(dataset.time, prediction.residual[:, joint], points, whole)
    _line(figure, *residual, row + 1, f"{label}: left", False, left)


def _line(
    figure: go.Figure, x: Floats, y: Floats, row: int, name: str, legend: bool, line: Mapping[str, object]
) -> None:
    x, y = np.asarray(x, np.float32), np.asarray(y, np.float32)
    trace = go.Scatter(x=x, y=y, name=name, mode="lines", line=line, legendgroup=name, showlegend=legend)
    figure.add_trace(trace, row=row, col=1)


def worst_windows(comparison: Comparison) -> go.Figure:
    """The stretches in which the model fails most: measured and computed torque, the stretch itself shaded."""
    windows = comparison.windows
    columns = min(COLUMNS, len(windows))
    rows = -(-len(windows) // columns)
    height = theme.HEADER + 12 + theme.FOOTER + 170 * rows + BETWEEN * (rows - 1)
    figure = theme.subplots(
        rows,
        columns,
        height,
        subplot_titles=[_caption(comparison, window) for window in windows],
        vertical_spacing=BETWEEN / (height - theme.HEADER - 12 - theme.FOOTER),
        horizontal_spacing=0.07,
    )
    for number, window in enumerate(windows):
        _stretch(figure, comparison, window, number // columns + 1, number % columns + 1, number == 0)
    theme.legend_entry(figure, "model", line={"color": theme.joint_colour(windows[0].joint - 1), "width": 1.6})
    figure.update_annotations(font_size=11.5)
    figure.update_layout(margin_t=theme.HEADER + 12)
    return figure


def _caption(comparison: Comparison, window: Window) -> str:
    cycle = f", cycle {window.cycle}" if window.cycle else ""
    where = f"{theme.escaped(window.recording)}<br>" if len(comparison.predictions) > 1 else ""
    return f"{where}{theme.joint_title(window.joint - 1)}: {window.phase}{cycle}, {window.times_overall:.1f} ×"


def _stretch(figure: go.Figure, comparison: Comparison, window: Window, row: int, column: int, legend: bool) -> None:
    prediction = next(
        one
        for one in comparison.predictions  # of a long recording there may be several parts
        if one.dataset.recording.path.name == window.recording and one.dataset.time[-1] > window.start
    )
    dataset, joint = prediction.dataset, window.joint - 1
    near = (dataset.time > window.start - AROUND) & (dataset.time < window.end + AROUND)
    time, measured = dataset.time[near], dataset.torque[near, joint]
    computed = np.where(np.isfinite(measured), prediction.computed[near, joint], np.nan)
    drawn = [
        ("measured", measured, {"color": theme.MEASURED, "width": 3.5}),
        ("computed", computed, {"color": theme.joint_colour(joint), "width": 1.6}),
    ]
    for name, values, line in drawn:
        shown = legend and name == "measured"
        figure.add_trace(
            go.Scatter(x=time, y=values, name=name, mode="lines", line=line, showlegend=shown), row=row, col=column
        )
    figure.add_vrect(
        x0=window.start, x1=window.end, fillcolor=theme.MEASURED, opacity=0.18, line_width=0, row=row, col=column
    )
    figure.update_xaxes(title_text="time [s]", row=row, col=column)
    figure.update_yaxes(title_text=theme.effort_label(comparison.joints[joint].unit), row=row, col=column)
