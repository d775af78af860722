"""Time plots that load their points again at every zoom, and plots of a run in progress."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from ident.output.figures import theme
from ident.residuals.time_span import TorqueSeries
from recordings.recording import Floats

Span = tuple[float, float]
Signal = tuple[str, Floats, NDArray[np.floating]]
"""Title of its axis; time (n,) [s]; values (n,)."""

_MAX_POINTS = 2400
"""Points of a line over the width of the page, at most."""
_SIGNAL_HEIGHT = 130
"""Of a signal below the torque [px]."""


def visible_points(time: NDArray[np.floating], y: NDArray[np.floating], span: Span) -> tuple[Floats, Floats]:
    """Return the points of `y` (n,) over `time` (n,) that are visible in `span`: extremes of each pixel and gaps."""
    # One point outside each edge, so that the line continues to the edge.
    first = max(int(np.searchsorted(time, span[0])) - 1, 0)
    last = min(int(np.searchsorted(time, span[1], side="right")) + 1, len(time))
    return theme.thinned(time[first:last].astype(float), y[first:last].astype(float), _MAX_POINTS)


def line(time: Floats, y: NDArray[np.floating], span: Span, **style: Any) -> go.Scatter:
    """Return a trace of `y` over `time` with the points that are visible in `span`."""
    xs, ys = visible_points(time, y, span)
    return go.Scatter(x=np.round(xs, 5), y=ys.astype(np.float32), **{"mode": "lines", **style})


def signal(name: str, unit: str, time: Floats, values: NDArray[np.floating], span: Span) -> go.Figure:
    """Plot the `values` (n, dof) of a signal over `time` (n,) for all joints."""
    figure = theme.subplots(1, 1, 340)
    for j in range(values.shape[1]):
        several = values.shape[1] > 1
        style = {"color": theme.joint_colour(j) if several else theme.MEASURED, "width": 1.2}
        label = f"joint {j + 1}" if several else name
        figure.add_trace(line(time, values[:, j], span, name=label, line=style, showlegend=several))
    figure.update_xaxes(title_text="time since the first SYNC [s]", range=list(span))
    figure.update_yaxes(title_text=f"{name} [{unit}]")
    figure.update_layout(hovermode="x unified")
    return figure


def torque_comparison(
    series: TorqueSeries,
    joint: int,
    unit: str,
    noise: float | None,
    span: Span,
    selecting: bool,
    below: Sequence[Signal] = (),
) -> go.Figure:
    """Plot measured and computed torque of a joint, the residual below, and other signals of it below that."""
    heights = [220, 180, *(_SIGNAL_HEIGHT for _ in below)]
    rows, height = len(heights), sum(heights) + 80
    gap = 24 / (height - 80)
    figure = theme.subplots(rows, 1, height, shared_xaxes=True, row_heights=heights, vertical_spacing=gap)
    colour, time, residual = theme.joint_colour(joint), series.time, series.residual[:, joint]
    thick, thin = {"color": theme.MEASURED, "width": 3.5}, {"color": colour, "width": 1.5}
    figure.add_trace(line(time, series.measured[:, joint], span, name="measured", line=thick), row=1, col=1)
    if series.previous is not None:
        _add_previous(figure, series, series.previous[:, joint], joint, span)
    figure.add_trace(line(time, series.computed[:, joint], span, name="model", line=thin), row=1, col=1)
    if noise is not None:
        theme.noise_bands(figure, {(2, 1): noise})
        theme.noise_legend(figure)
    # Plotly selects markers only, so the line gets nearly invisible ones.
    style = {"mode": "lines+markers", "marker": {"size": 2, "opacity": 0.01, "color": colour}, "showlegend": False}
    residual_line = line(time, residual, span, name="residual", line={"color": colour, "width": 1.1}, **style)
    figure.add_trace(residual_line, row=2, col=1)
    figure.update_yaxes(title_text=theme.effort_label(unit), row=1, col=1)
    figure.update_yaxes(title_text=f"residual [{unit}]", row=2, col=1)
    figure.update_xaxes(range=list(span))
    for row, (title, times, values) in enumerate(below, start=3):
        figure.add_trace(line(times, values, span, line={"color": colour, "width": 1.1}, showlegend=False), row, 1)
        figure.update_yaxes(title_text=title, nticks=4, row=row, col=1)
    figure.update_xaxes(title_text="time since the first SYNC [s]", row=rows, col=1)
    figure.update_layout(
        dragmode="select" if selecting else "zoom",
        selectdirection="h",
        hovermode=False if selecting else "x unified",
    )
    return figure


def _add_previous(figure: go.Figure, series: TorqueSeries, torque: Floats, joint: int, span: Span) -> None:
    """Add torque and residual of the model before the last change."""
    residual = np.where(series.scored[:, joint], series.measured[:, joint] - torque, np.nan)
    style = {"line": {"color": theme.CATEGORIES[1], "width": 1, "dash": "dot"}, "legendgroup": "previous"}
    figure.add_trace(line(series.time, torque, span, name="model before", **style), row=1, col=1)
    below = line(series.time, residual, span, name="model before", showlegend=False, **style)
    figure.add_trace(below, row=2, col=1)


def live(time: Sequence[float], curves: Sequence[Sequence[float | None]], kind: str, unit: str) -> go.Figure:
    """Plot one quantity of the run in progress: a curve for each joint, or that of the lateness."""
    figure = theme.subplots(1, 1, 200)
    for j, y in enumerate(curves):
        colour = theme.MEASURED if kind == "lateness" else theme.joint_colour(j)
        style = {"color": colour, "width": 1.2}
        figure.add_trace(go.Scatter(x=time, y=y, mode="lines", name=f"joint {j + 1}", line=style))
    figure.update_xaxes(title_text="time [s]")
    figure.update_yaxes(title_text=f"{kind}<br>[{unit}]")
    figure.update_layout(showlegend=kind == "position", margin={"t": 30, "b": 40})
    return figure
