"""Draw measured and computed torque and the residual over time."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.identification.prediction import Prediction
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis
from ident.residuals.windows import Window
from recordings.recording import Floats

WINDOW_MARGIN = 0.5
"""Time that is drawn before and after a worst window [s]."""
MAX_COLUMNS = 3
ROW_GAP = 84
"""Height between rows of plots, for the axis labels of one and the titles of the next [px]."""


def over_time(analyses: Mapping[str, ResidualAnalysis], index: int, points: int = theme.MAX_POINTS) -> go.Figure:
    """Draw for each joint the torque and below it the residual, in recording `index` of all analyses.

    All plots share one time axis. It shows the first repetition, a double click all. Each trace has every sample
    of the first repetition and `points` of the whole recording.
    """
    first, *_ = analyses.values()
    prepared = first.predictions[index].prepared
    dof = len(first.joints)
    figure = theme.subplots(
        2 * dof,
        1,
        theme.LEGEND + theme.FOOTER + 160 * dof,
        shared_xaxes=True,
        row_heights=[2, 1] * dof,
        vertical_spacing=0.08 / dof,
    )
    for joint, joint_residual in enumerate(first.joints):
        row = 2 * joint + 1
        time, measured = theme.thinned(prepared.time, prepared.torque[:, joint], points, prepared.first_cycle)
        thick = {"color": theme.MEASURED, "width": 3.5}
        _line(figure, time, measured, row, "measured", joint == 0, thick)
        for number, (name, analysis) in enumerate(analyses.items()):
            label = theme.escaped(name) if len(analyses) > 1 else "model"
            _draw_model(figure, analysis.predictions[index], joint, number, label, points)
        theme.noise_band(figure, joint_residual.noise_rms, row + 1, 1, joint == 0)
        figure.update_yaxes(
            title_text=f"{theme.joint_title(joint)}<br>{theme.effort_label(joint_residual.unit)}", row=row, col=1
        )
        figure.update_yaxes(title_text=f"residual<br>[{joint_residual.unit}]", nticks=4, row=row + 1, col=1)
    visible = prepared.time[prepared.first_cycle]
    figure.update_xaxes(range=[float(visible[0]), float(visible[-1])])
    figure.update_xaxes(title_text="time [s]", row=2 * dof, col=1)
    figure.update_layout(hovermode="x unified", hoversubplots="axis")
    return figure


def _draw_model(figure: go.Figure, prediction: Prediction, joint: int, number: int, label: str, points: int) -> None:
    prepared = prediction.prepared
    kept = prepared.first_cycle
    finite = np.isfinite(prepared.torque[:, joint])
    line = {"color": theme.joint_colour(joint), "width": 1.5, "dash": theme.DASHES[number % len(theme.DASHES)]}
    computed = np.where(finite, prediction.computed[:, joint], np.nan)
    row = 2 * joint + 1
    _line(figure, *theme.thinned(prepared.time, computed, points, kept), row, label, joint == 0, line)
    thin = line | {"width": 1.1}
    residual = theme.thinned(prepared.time, prediction.residual[:, joint], points, kept)
    _line(figure, *residual, row + 1, f"{label}: residual", False, thin)


def _line(
    figure: go.Figure, x: Floats, y: Floats, row: int, name: str, legend: bool, line: Mapping[str, object]
) -> None:
    x, y = np.asarray(x, np.float32), np.asarray(y, np.float32)
    trace = go.Scatter(x=x, y=y, name=name, mode="lines", line=line, legendgroup=name, showlegend=legend)
    figure.add_trace(trace, row=row, col=1)


def worst_windows(analysis: ResidualAnalysis) -> go.Figure:
    """Draw measured and computed torque in the worst windows, which are shaded."""
    windows = analysis.windows
    columns = min(MAX_COLUMNS, len(windows))
    rows = -(-len(windows) // columns)
    height = theme.HEADER + 12 + theme.FOOTER + 170 * rows + ROW_GAP * (rows - 1)
    figure = theme.subplots(
        rows,
        columns,
        height,
        subplot_titles=[_window_title(analysis, window) for window in windows],
        vertical_spacing=ROW_GAP / (height - theme.HEADER - 12 - theme.FOOTER),
        horizontal_spacing=0.07,
    )
    for number, window in enumerate(windows):
        _draw_window(figure, analysis, window, number // columns + 1, number % columns + 1, number == 0)
    theme.legend_entry(figure, "model", line={"color": theme.joint_colour(windows[0].joint - 1), "width": 1.6})
    figure.update_annotations(font_size=11.5)
    figure.update_layout(margin_t=theme.HEADER + 12)
    return figure


def _window_title(analysis: ResidualAnalysis, window: Window) -> str:
    cycle = f", cycle {window.cycle}" if window.cycle else ""
    prefix = f"{theme.escaped(window.recording)}<br>" if len(analysis.predictions) > 1 else ""
    return f"{prefix}{theme.joint_title(window.joint - 1)}: {window.phase}{cycle}, {window.times_overall:.1f} ×"


def _draw_window(
    figure: go.Figure, analysis: ResidualAnalysis, window: Window, row: int, column: int, legend: bool
) -> None:
    prediction = next(
        prediction
        for prediction in analysis.predictions  # a long recording may consist of several parts
        if prediction.prepared.recording.path.name == window.recording and prediction.prepared.time[-1] > window.start
    )
    prepared, joint = prediction.prepared, window.joint - 1
    rows = (prepared.time > window.start - WINDOW_MARGIN) & (prepared.time < window.end + WINDOW_MARGIN)
    time, measured = prepared.time[rows], prepared.torque[rows, joint]
    computed = np.where(np.isfinite(measured), prediction.computed[rows, joint], np.nan)
    traces = [
        ("measured", measured, {"color": theme.MEASURED, "width": 3.5}),
        ("computed", computed, {"color": theme.joint_colour(joint), "width": 1.6}),
    ]
    for name, values, line in traces:
        in_legend = legend and name == "measured"
        figure.add_trace(
            go.Scatter(x=time, y=values, name=name, mode="lines", line=line, showlegend=in_legend),
            row=row,
            col=column,
        )
    figure.add_vrect(
        x0=window.start, x1=window.end, fillcolor=theme.MEASURED, opacity=0.18, line_width=0, row=row, col=column
    )
    figure.update_xaxes(title_text="time [s]", row=row, col=column)
    figure.update_yaxes(title_text=theme.effort_label(analysis.joints[joint].unit), row=row, col=column)
