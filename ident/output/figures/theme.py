"""What all figures share: colours, templates, digits, and how long traces are thinned out."""

import html
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from recordings.recording import Floats, Ints
from web.palette import JOINTS as JOINTS
from web.palette import MEASURED as MEASURED
from web.palette import NOISE as NOISE

DASHES = ("solid", "dash", "dot", "dashdot")
"""Of the first model, the second, and so on."""
_PATTERNS = ("", "/", ".", "x")
SYMBOLS = ("circle", "diamond", "square", "triangle-up")
FAINT_OPACITY = 0.45
"""Opacity of what is compared with."""

MAX_POINTS = 4000
"""Of a trace, at most: about two for each pixel of a wide screen."""
LEGEND, TITLES = 34, 26
"""Pixels above the plots."""
HEADER = LEGEND + TITLES
FOOTER = 46
"""Pixels below, for the labels of the last axis."""

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
            "xaxis": axis,
            "yaxis": axis,
            "hoverlabel": {"bgcolor": ground, "bordercolor": lines, "font": {"color": ink, "family": _FONT}},
            "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": MEASURED, "activecolor": ink},
            "legend": {"bgcolor": "rgba(0,0,0,0)"},
        }
    )


LIGHT = _template("#1c2126", "#dfe3e8", "#ffffff")
DARK = _template("#e4e7eb", "#363c44", "#20252b")


def subplots(rows: int, columns: int, height: int, **arguments: Any) -> go.Figure:
    """A figure of `rows` by `columns` plots in the common style, `height` pixels high; legend in a row on top."""
    figure = make_subplots(rows=rows, cols=columns, **arguments)
    top = HEADER if arguments.get("subplot_titles") else LEGEND
    figure.update_layout(
        template=LIGHT,
        height=height,
        margin={"l": 64, "r": 14, "t": top, "b": FOOTER},
        legend={"orientation": "h", "yref": "container", "y": 1, "yanchor": "top", "x": 0, "xanchor": "left"},
    )
    figure.update_annotations(font_size=13)
    figure.update_xaxes(hoverformat=".4g")
    figure.update_yaxes(hoverformat=".3g")
    return figure


def bar_pattern(number: int) -> dict[str, str]:
    """Of the bars of a model (from 0)."""
    return {"shape": _PATTERNS[number % len(_PATTERNS)], "fillmode": "overlay", "fgcolor": "#ffffff"}


def joint_colour(joint: int) -> str:
    """Of the joint (from 0)."""
    return JOINTS[joint % len(JOINTS)]


def with_opacity(colour: str, opacity: float) -> str:
    """`colour` as CSS with an opacity."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"


def number(value: float | None, digits: int = 3) -> str:
    """`value` with so many significant digits, without an exponent where it can be helped."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    magnitude = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -5 <= magnitude < 7:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, digits - 1 - magnitude)}f}"


def percent(share: float | None) -> str:
    """A share from 0 to 1 in percent, with one decimal where it is near either end."""
    if share is None or not math.isfinite(share):
        return "–"
    if 0.9995 <= share < 1:
        return "> 99.9\u00a0%"
    few = abs(share) < 0.0995 or 0.99 < share < 1
    return f"{100 * share:.{1 if few and share else 0}f}\u00a0%"


def with_equal_decimals(values: Sequence[float]) -> list[str]:
    """Numbers to be compared, all with as many decimals as give the largest two significant digits."""
    most = max(map(abs, values), default=0.0)
    decimals = max(0, 1 - math.floor(math.log10(most))) if most else 0
    return [f"{value:.{decimals}f}" for value in values]


def interval(low: float, high: float) -> str:
    """An interval, with two significant digits of its half width."""
    half = (high - low) / 2
    if not (math.isfinite(half) and half > 0):
        return f"{number(low)} to {number(high)}"
    decimals = max(0, 1 - math.floor(math.log10(half)))
    return f"{low:.{decimals}f} to {high:.{decimals}f}" if decimals < 9 else f"{low:.3g} to {high:.3g}"


def escaped(text: str) -> str:
    """`text` from a file as it is: Plotly takes some tags in labels for markup."""
    return html.escape(text, quote=False)


def effort_label(unit: str) -> str:
    """Name and unit of an effort."""
    return f"{'force' if unit == 'N' else 'torque'} [{unit}]"


def thinned(x: Floats, y: Floats, points: int = MAX_POINTS, kept: slice | None = None) -> tuple[Floats, Floats]:
    """`y` (n,) over ascending `x` (n,), by the extremes in each pixel, and all of `whole`: peaks and gaps stay."""
    chosen = _extremes(y, points)
    if kept is not None:
        chosen = np.union1d(chosen, np.arange(len(y))[kept])
    return x[chosen], y[chosen]


def _extremes(y: Floats, points: int) -> Ints:
    size = math.ceil(2 * len(y) / points)
    if size <= 2:
        return np.arange(len(y))
    buckets = -(-len(y) // size)
    padded = np.concatenate([y, np.full(buckets * size - len(y), np.nan)]).reshape(buckets, size)
    unknown = np.isnan(padded)
    first = np.arange(buckets) * size
    lowest = np.where(unknown, np.inf, padded).argmin(axis=1)
    highest = np.where(unknown, -np.inf, padded).argmax(axis=1)
    gaps = unknown.argmax(axis=1)[unknown.any(axis=1)] + first[unknown.any(axis=1)]
    chosen = np.unique(np.concatenate([lowest + first, highest + first, gaps]))
    return chosen[chosen < len(y)]


def noise_band(figure: go.Figure, half_width: float | None, row: int, column: int, label: bool) -> None:
    """Mark plus and minus the noise floor, if it is known."""
    if half_width is None:
        return
    place = {"row": row, "col": column, "exclude_empty_subplots": False}
    style = {"fillcolor": NOISE, "opacity": 0.22, "line_width": 0, "layer": "below"}
    figure.add_hrect(y0=-half_width, y1=half_width, **style, **place)
    if label:
        legend_entry(figure, "± noise floor", marker={"symbol": "square", "size": 12, "color": with_opacity(NOISE, 0.3)})


def legend_entry(figure: go.Figure, name: str, **style: Any) -> None:
    """An entry of the legend for what is not a trace of its own."""
    mode = "markers" if "marker" in style else "lines"
    figure.add_trace(go.Scatter(x=[None], y=[None], name=name, mode=mode, hoverinfo="skip", **style), row=1, col=1)


def joint_titles(joints: int) -> Sequence[str]:
    """Of one plot per joint, each in the joint's colour."""
    return [joint_title(joint) for joint in range(joints)]


def joint_title(joint: int) -> str:
    """The joint's (from 0) name in its colour."""
    return f"<b style='color:{joint_colour(joint)}'>joint {joint + 1}</b>"
