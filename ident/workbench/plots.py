"""Figures for Plotly, as plain dictionaries, in the colours of the page."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ident.workbench.decimate import decimate
from ident.workbench.views import LadderView, RecordingView, Series
from recordings.recording import Floats

Figure = dict[str, Any]

JOINTS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Of Okabe and Ito's palette: safe for colour blindness, the same for a joint everywhere."""
TRAIN, HELD_OUT, NOISE = "#E69F00", "#0072B2", "#009E73"
_CONFIG = {"displaylogo": False, "responsive": True, "modeBarButtonsToRemove": ["lasso2d", "autoScale2d"]}


def layout(dark: bool, height: int, **more: Any) -> dict[str, Any]:
    """What all figures share."""
    ink, grid = ("#e6e9ec", "#3a4148") if dark else ("#22272b", "#dfe3e6")
    axis = {"gridcolor": grid, "zerolinecolor": grid, "linecolor": grid, "automargin": True}
    found: dict[str, Any] = {
        "height": height,
        "margin": {"l": 64, "r": 16, "t": 24, "b": 44},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "Roboto, sans-serif", "size": 13, "color": ink},
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom"},
        "hovermode": "x unified",
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#8a9099", "activecolor": ink},
        "hoverlabel": {"bgcolor": "#2b3136" if dark else "#ffffff", "font": {"color": ink}},
        "uirevision": "kept",
    }
    for key, value in more.items():
        found[key] = {**axis, **value} if key.startswith(("xaxis", "yaxis")) else value
    return found


def figure(data: list[dict[str, Any]], shown: dict[str, Any]) -> Figure:
    """Both together."""
    return {"data": data, "layout": shown, "config": _CONFIG}


def numbers(x: NDArray[np.floating]) -> list[float | None]:
    """JSON knows no NaN; Plotly shows a gap where nothing is."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in x]


def line(time: Floats, y: NDArray[np.floating], span: tuple[float, float], **style: Any) -> dict[str, Any]:
    """`y` over `time`, as many points of it as `span` needs."""
    xs, ys = decimate(time, y, *span)
    return {"type": "scatter", "mode": "lines", "x": numbers(xs), "y": numbers(ys), **style}


def signal(view: RecordingView, name: str, span: tuple[float, float], dark: bool) -> Figure:
    """One signal of a recording, all joints."""
    unit, values = view.signals[name]
    several = values.shape[1] > 1
    data = [
        line(
            view.time,
            values[:, j],
            span,
            name=f"joint {j + 1}" if several else name,
            line={"color": JOINTS[j % len(JOINTS)], "width": 1.2},
        )
        for j in range(values.shape[1])
    ]
    axes = {
        "xaxis": {"title": {"text": "time since the first SYNC [s]"}, "range": list(span)},
        "yaxis": {"title": {"text": f"{name} [{unit}]"}},
    }
    return figure(data, layout(dark, 330, **axes))


def against(series: Series, joint: int, unit: str, span: tuple[float, float], marking: bool, dark: bool) -> Figure:
    """Measured torque against the model's, above what is left of it."""
    ink = "#e6e9ec" if dark else "#22272b"
    left, time = series.residual[:, joint], series.time
    data = [
        line(time, series.measured[:, joint], span, name="measured", line={"color": ink, "width": 1.4}),
        line(
            time,
            series.computed[:, joint],
            span,
            name="model",
            line={"color": "#E69F00", "width": 1.4, "dash": "4px,2px"},
        ),
        # Markers that are not seen make the line something that can be marked.
        line(time, left, span, name="residual", line={"color": JOINTS[joint % len(JOINTS)], "width": 1.2})
        | {"yaxis": "y2", "mode": "lines+markers", "marker": {"size": 2, "opacity": 0.01}},
    ]
    axes = {
        "xaxis": {"title": {"text": "time since the first SYNC [s]"}, "range": list(span), "anchor": "y2"},
        "yaxis": {"title": {"text": f"torque [{unit}]"}, "domain": [0.47, 1.0]},
        "yaxis2": {"title": {"text": f"residual [{unit}]"}, "domain": [0.0, 0.42]},
    }
    mode = {"dragmode": "select" if marking else "zoom", "selectdirection": "h"}
    return figure(data, layout(dark, 470, **axes, **mode))


def ladder(view: LadderView, dark: bool) -> Figure:
    """Error of each model on what it was fitted to and on what it never saw, joint by joint, and the noise line."""
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {}
    shapes: list[dict[str, Any]] = []
    dof, gap = len(view.joints), 0.055
    names = [f"{number}  {rung.label}" for number, rung in enumerate(view.rungs)]
    for j in range(dof):
        suffix = "" if j == 0 else str(j + 1)
        for values, name, colour in (
            ([rung.entry.train_rms[j] for rung in view.rungs], "training", TRAIN),
            ([rung.entry.validate_rms[j] for rung in view.rungs], "held out", HELD_OUT),
        ):
            data.append(
                {
                    "type": "bar",
                    "x": names,
                    "y": [float(f"{value:.4g}") for value in values],
                    "name": name,
                    "legendgroup": name,
                    "showlegend": j == 0,
                    "marker": {"color": colour},
                    "xaxis": f"x{suffix}",
                    "yaxis": f"y{suffix}",
                }
            )
        start, end = j / dof + (gap if j else 0), (j + 1) / dof
        axes[f"xaxis{suffix}"] = {
            "domain": [start, end],
            "anchor": f"y{suffix}",
            "tickangle": -20,
            "type": "category",
        }
        axes[f"yaxis{suffix}"] = {
            "title": {"text": f"joint {j + 1}  RMS error [{view.units[j]}]", "standoff": 4},
            "anchor": f"x{suffix}",
            "rangemode": "tozero",
        }
        shapes.append(
            {
                "type": "line",
                "xref": f"x{suffix} domain",
                "yref": f"y{suffix}",
                "x0": 0,
                "x1": 1,
                "y0": view.noise_rms[j],
                "y1": view.noise_rms[j],
                "line": {"color": NOISE, "width": 2, "dash": "dash"},
                "name": "noise line",
                "legendgroup": "noise",
                "showlegend": j == 0,
            }
        )
    shown = layout(dark, 300, **axes, shapes=shapes, barmode="group", bargap=0.35)
    return figure(data, {**shown, "hovermode": "closest", "transition": {"duration": 400}})


def live(rows: list[dict[str, Any]], late: list[tuple[float, float]], kind: str) -> list[dict[str, Any]]:
    """Lines of one quantity of a run that is going on."""
    if kind == "lateness":
        times, values = [time for time, _ in late], [[1e3 * value for _, value in late]]
    else:
        times = [row["time"] for row in rows]
        values = [list(column) for column in zip(*(_values(row, kind) for row in rows), strict=True)]
    return [
        {
            "type": "scatter",
            "mode": "lines",
            "x": times,
            "y": y,
            "name": f"joint {j + 1}" if kind != "lateness" else "worst since the last look",
            "line": {"color": JOINTS[j % len(JOINTS)], "width": 1.2},
        }
        for j, y in enumerate(values)
    ]


def _values(row: dict[str, Any], kind: str) -> list[float | None]:
    if kind != "following error":
        found: list[float | None] = row[kind]
        return found
    pairs = zip(row["command"], row["position"], strict=True)
    return [None if a is None or b is None else 1e3 * (a - b) for a, b in pairs]
