"""Draw measured and computed torque and the residual over time."""

from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go

from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.diagnosis import Diagnosis
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis
from ident.residuals.phases import Window
from recordings.recording import Floats

WINDOW_MARGIN = 0.5
"""Time that is drawn before and after a worst window [s]."""
MAX_COLUMNS = 3
ROW_GAP = 84
"""Height between rows of plots, for the axis labels of one and the titles of the next [px]."""


Overlay = tuple[Floats, Floats, Mapping[str, object]]
"""Torque of a model and its residual (m, dof) [N m], and the style of their lines beside the colour of the joint."""


def over_time(analyses: Mapping[str, ResidualAnalysis], index: int, points: int = theme.MAX_POINTS) -> go.Figure:
    """Draw for each joint the torque and below it the residual, in recording `index` of all analyses.

    All plots share one time axis. It shows the first repetition, a double click all. Each trace has every sample
    of the first repetition and `points` of the whole recording.
    """
    first, *_ = analyses.values()
    overlays = {}
    for number, (name, analysis) in enumerate(analyses.items()):
        prediction = analysis.predictions[index]
        dash = {"dash": theme.DASHES[number % len(theme.DASHES)]}
        label = theme.escaped(name) if len(analyses) > 1 else "model"
        overlays[label] = prediction.computed, prediction.residual, dash
    noise = [joint.noise_rms for joint in first.joints]
    return _over_time(first.predictions[index].prepared, overlays, noise, points)


def before_and_after(diagnosis: Diagnosis, index: int, points: int = theme.MAX_POINTS) -> go.Figure:
    """Draw torque and residual of the first and the last model of a `diagnosis` in its recording `index`."""
    steps, prepared = diagnosis.selection.steps, diagnosis.split.recordings[index]
    before, after = steps[0].model, diagnosis.model
    overlays: dict[str, Overlay] = {
        "before": (before.computed[index], before.residuals[index], {"color": theme.CATEGORIES[1]}),
        "after": (after.computed[index], after.residuals[index], {}),
    }
    return _over_time(prepared, overlays, after.noise_floor.rms.tolist(), points)


def _over_time(
    prepared: PreparedRecording, overlays: Mapping[str, Overlay], noise: Sequence[float | None], points: int
) -> go.Figure:
    rig, kept = prepared.recording.rig, prepared.first_cycle
    dof = rig.dof
    figure = theme.subplots(
        2 * dof,
        1,
        theme.LEGEND + theme.FOOTER + 160 * dof,
        shared_xaxes=True,
        row_heights=[2, 1] * dof,
        vertical_spacing=0.08 / dof,
    )
    for joint, unit in enumerate(rig.effort_units):
        row, measured = 2 * joint + 1, prepared.torque[:, joint]
        thick = {"color": theme.MEASURED, "width": 3.5}
        _line(figure, *theme.thinned(prepared.time, measured, points, kept), row, "measured", joint == 0, thick)
        for name, (computed, residual, style) in overlays.items():
            line = {"color": theme.joint_colour(joint), "width": 1.5, **style}
            known = np.where(np.isfinite(measured), computed[:, joint], np.nan)
            x, y = theme.thinned(prepared.time, known, points, kept)
            _line(figure, x, y, row, name, joint == 0, line)
            x, y = theme.thinned(prepared.time, residual[:, joint], points, kept)
            _line(figure, x, y, row + 1, f"{name}: residual", False, line | {"width": 1.1})
        label = f"{theme.joint_title(joint)}<br>{theme.effort_label(unit)}"
        figure.update_yaxes(title_text=label, row=row, col=1)
        figure.update_yaxes(title_text=f"residual<br>[{unit}]", nticks=4, row=row + 1, col=1)
    theme.noise_bands(figure, {(2 * joint + 2, 1): noise[joint] for joint in range(dof)})
    if noise[0] is not None:
        theme.noise_legend(figure)
    visible = prepared.time[kept]
    figure.update_xaxes(range=[float(visible[0]), float(visible[-1])])
    figure.update_xaxes(title_text="time [s]", row=2 * dof, col=1)
    figure.update_layout(hovermode="x unified", hoversubplots="axis", meta={theme.WHOLE: True})
    return figure


def _line(
    figure: go.Figure, x: Floats, y: Floats, row: int, name: str, legend: bool, line: Mapping[str, object]
) -> None:
    style = {"mode": "lines", "line": line, "legendgroup": name, "showlegend": legend}
    figure.add_scatter(x=np.asarray(x, np.float32), y=np.asarray(y, np.float32), name=name, **style, row=row, col=1)


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
        title_size=11.5,
        subplot_titles=[_window_title(analysis, window) for window in windows],
        vertical_spacing=ROW_GAP / (height - theme.HEADER - 12 - theme.FOOTER),
        horizontal_spacing=0.07,
    )
    for number, window in enumerate(windows):
        _draw_window(figure, analysis, window, number // columns + 1, number % columns + 1, number == 0)
    theme.legend_entry(figure, "model", line={"color": theme.joint_colour(windows[0].joint - 1), "width": 1.6})
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
    place = {"row": row, "col": column}
    thick = {"color": theme.MEASURED, "width": 3.5}
    thin = {"color": theme.joint_colour(joint), "width": 1.6}
    figure.add_scatter(x=time, y=measured, name="measured", mode="lines", line=thick, showlegend=legend, **place)
    figure.add_scatter(x=time, y=computed, name="computed", mode="lines", line=thin, showlegend=False, **place)
    style = {"fillcolor": theme.MEASURED, "opacity": 0.18, "line_width": 0}
    figure.add_vrect(x0=window.start, x1=window.end, **style, **place)
    figure.update_xaxes(title_text="time [s]", **place)
    figure.update_yaxes(title_text=theme.effort_label(analysis.joints[joint].unit), **place)
