"""Common style of all figures: colours, templates, and decimation of long traces."""

import html
import importlib.resources
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from delta_web.palette import CATEGORIES as CATEGORIES
from delta_web.palette import JOINTS
from delta_web.palette import MEASURED as MEASURED
from delta_web.palette import NOISE as NOISE
from recordings.recording import Floats, Ints

DASHES = ("solid", "dash", "dot", "dashdot")
"""Line styles of the first model, the second, and so on."""
_PATTERNS = ("", "/", ".", "x")
NOISE_LINE = {"color": NOISE, "width": 2, "dash": "dash"}
"""Line of a noise floor that is one number."""
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
FAINT_OPACITY = 0.45
"""Opacity of the reference that is compared with."""

WHOLE = "whole"
"""Key of `layout.meta` of a figure that shows a part at first, and the whole after a double click."""
FIRST = "first"
"""Key of `layout.meta`: which plot, from 0 in the order of reading, is shown where there is room for one."""
MAX_POINTS = 4000
"""Number of points of a trace at most: about two for each pixel of a wide screen."""
LEGEND, TITLES = 34, 26
"""Height above the plots [px]."""
HEADER = LEGEND + TITLES
FOOTER = 46
"""Height below the plots, for the labels of the last axis [px]."""

_FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif"


def _template(ink: str, lines: str, ground: str) -> go.layout.Template:
    axis = {
        "gridcolor": lines,
        "linecolor": lines,
        "zeroline": False,
        "ticks": "outside",
        "tickcolor": lines,
        "ticklen": 4,
        "automargin": True,
        "title": {"standoff": 6, "font": {"size": 12}},
        "tickfont": {"size": 11},
    }
    return go.layout.Template(
        layout={
            "font": {"family": _FONT, "size": 12, "color": ink},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "xaxis": {**axis, "hoverformat": ".4g"},
            "yaxis": {**axis, "hoverformat": ".3g"},
            "hoverlabel": {"bgcolor": ground, "bordercolor": lines, "font": {"color": ink, "family": _FONT}},
            "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": MEASURED, "activecolor": ink},
            "legend": {
                "bgcolor": "rgba(0,0,0,0)",
                "orientation": "h",
                "yref": "container",
                "y": 1,
                "yanchor": "top",
                "x": 0,
                "xanchor": "left",
            },
        }
    )


LIGHT = _template("#1c2126", "#dfe3e8", "#ffffff")
DARK = _template("#e4e7eb", "#363c44", "#20252b")


def subplots(rows: int, columns: int, height: int, title_size: float = 13, **arguments: Any) -> go.Figure:
    """Return a figure of `rows` by `columns` plots in the common style, `height` pixels high, legend on top."""
    margin = {"l": 64, "r": 14, "t": HEADER if arguments.get("subplot_titles") else LEGEND, "b": FOOTER}
    empty = go.Figure(layout={"template": LIGHT, "height": height, "margin": margin})
    figure = make_subplots(rows=rows, cols=columns, figure=empty, **arguments)
    for title in figure.layout.annotations:
        title.font.size = title_size  # update_annotations takes longer than all the rest
    return figure


def beside_each_other(joints: Sequence[int], height: int, **arguments: Any) -> go.Figure:
    """Return `subplots` with one plot for each of `joints` (from 0) under its title, on a common scale."""
    titles = [joint_title(joint) for joint in joints]
    options = {"shared_yaxes": "all", "horizontal_spacing": 0.04, **arguments}
    return subplots(1, len(joints), height, subplot_titles=titles, **options)


def narrow_javascript() -> str:
    """Return JavaScript that defines `figuresOnNarrowPages`, which stacks the plots of a page with Plotly."""
    return (importlib.resources.files("ident.output.figures") / "narrow.js").read_text(encoding="utf-8")


def bar_pattern(number: int) -> dict[str, str]:
    """Return the fill pattern for the bars of model `number` (from 0)."""
    return {"shape": _PATTERNS[number % len(_PATTERNS)], "fillmode": "overlay", "fgcolor": "#ffffff"}


def joint_colour(joint: int) -> str:
    """Return the colour of `joint` (from 0)."""
    return JOINTS[joint % len(JOINTS)]


def with_opacity(colour: str, opacity: float) -> str:
    """Return `colour` with an opacity as CSS."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"


def escaped(text: str) -> str:
    """Escape `text` from a file: Plotly interprets some tags in labels as markup."""
    return html.escape(text, quote=False)


def axis_label(axis: str, unit: str) -> str:
    """Name a quantity with its unit."""
    name = {"load": "computed load", "motor angle": "position"}.get(axis, axis)
    return f"{name} [{unit}]" if unit else name


def effort_label(unit: str) -> str:
    """Return name and unit of an effort."""
    return f"{'force' if unit == 'N' else 'torque'} [{unit}]"


def thinned(x: Floats, y: Floats, points: int = MAX_POINTS, kept: slice | None = None) -> tuple[Floats, Floats]:
    """Decimate `y` (n,) over ascending `x` (n,) to the extremes of each pixel; peaks, gaps and all of `kept` stay."""
    indices = _extremes(y, points)
    if kept is not None:
        indices = np.union1d(indices, np.arange(len(y))[kept])
    return x[indices], y[indices]


def _extremes(y: Floats, points: int) -> Ints:
    size = math.ceil(2 * len(y) / points)
    if size <= 2:
        return np.arange(len(y))
    buckets = -(-len(y) // size)
    padded = np.concatenate([y, np.full(buckets * size - len(y), np.nan)]).reshape(buckets, size)
    missing = np.isnan(padded)
    first = np.arange(buckets) * size
    lowest = np.where(missing, np.inf, padded).argmin(axis=1)
    highest = np.where(missing, -np.inf, padded).argmax(axis=1)
    gaps = missing.argmax(axis=1)[missing.any(axis=1)] + first[missing.any(axis=1)]
    indices = np.unique(np.concatenate([lowest + first, highest + first, gaps]))
    return indices[indices < len(y)]


def noise_bands(figure: go.Figure, half_widths: Mapping[tuple[int, int], float | None]) -> None:
    """Mark plus and minus the noise floor in the plots at (row, column) for which it is known."""
    bands = []
    for place, half_width in half_widths.items():
        if half_width is not None:
            axes = figure.get_subplot(*place)
            across, along = (axis.plotly_name.replace("axis", "") for axis in (axes.xaxis, axes.yaxis))
            width = {"xref": f"{across} domain", "x0": 0, "x1": 1}
            height = {"yref": along, "y0": -half_width, "y1": half_width}
            style = {"fillcolor": NOISE, "opacity": 0.22, "line": {"width": 0}, "layer": "below"}
            bands.append({"type": "rect", **width, **height, **style})
    figure.layout.shapes = bands  # to add one after the other takes as long as all of the figure's curves


def noise_legend(figure: go.Figure) -> None:
    """Add a legend entry for the band of the noise floor."""
    marker = {"symbol": "square", "size": 12, "color": with_opacity(NOISE, 0.3)}
    legend_entry(figure, "± noise floor", marker=marker)


def legend_entry(figure: go.Figure, name: str, **style: Any) -> None:
    """Add a legend entry for something that is not a trace."""
    mode = "markers" if "marker" in style else "lines"
    figure.add_scatter(x=[None], y=[None], name=name, mode=mode, hoverinfo="skip", **style, row=1, col=1)


def joint_title(joint: int) -> str:
    """Return the name of `joint` (from 0) beside its colour, in which letters would lack contrast."""
    return f"<span style='color:{joint_colour(joint)}'>■</span> <b>joint {joint + 1}</b>"
