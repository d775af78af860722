"""Draw the uncertainty of the parameters."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.identification.model_file import FittedParameter, ModelFile
from ident.output.assessment import half_width
from ident.output.figures import theme

_IDENTIFIABLE = {"identifiable": "identifiable", "weak": "weakly identifiable", "not": "not identifiable"}
_TICKS = [step * 10.0**exponent for exponent in range(-3, 5) for step in (1, 2, 5)]
_COLOURS = dict(zip(_IDENTIFIABLE, theme.CATEGORIES, strict=True))


def precision(models: Mapping[str, ModelFile]) -> go.Figure:
    """Draw half the width of each parameter's 95 % interval, in percent of its value, on a logarithmic axis."""
    names = list(dict.fromkeys(parameter.name for model in models.values() for parameter in model.parameters))
    figure = theme.subplots(1, 1, theme.LEGEND + theme.FOOTER + 22 * len(names))
    for number, (name, model) in enumerate(models.items()):
        for status, label in _IDENTIFIABLE.items():
            parameters = [
                entry
                for entry in model.parameters
                if entry.status == status and relative_half_width(entry) is not None
            ]
            if not parameters:
                continue
            figure.add_scatter(
                x=[relative_half_width(entry) for entry in parameters],
                y=[theme.escaped(entry.name) for entry in parameters],
                mode="markers",
                name=f"{theme.escaped(name)}, {label}" if len(models) > 1 else label,
                marker={"color": _COLOURS[status], "size": 10, "symbol": theme.SYMBOLS[number % len(theme.SYMBOLS)]},
                hovertemplate="%{y}: ± %{x:.2g} %",
            )
    figure.update_yaxes(categoryorder="array", categoryarray=[theme.escaped(name) for name in names[::-1]])
    figure.update_xaxes(type="log", title_text="half width of the 95 % interval [% of the value]", tickvals=_TICKS)
    figure.update_xaxes(ticktext=[f"{tick:g}" for tick in _TICKS])
    figure.update_layout(showlegend=True)
    figure.add_vline(x=100, line={"color": theme.MEASURED, "dash": "dot", "width": 1.5})
    return figure


def relative_half_width(parameter: FittedParameter) -> float | None:
    """Return half the width of the 95 % interval in percent of the value; None without an interval."""
    half = half_width(parameter)
    return 100 * half / abs(parameter.value) if half is not None and parameter.value else None


def correlation(model: ModelFile) -> go.Figure:
    """Draw the correlation of the parameters' errors; near -1 or 1 only a combination of two is known."""
    rows = model.assessment.correlation if model.assessment else ()
    names = [theme.escaped(parameter.name) for parameter in (*model.parameters, *model.searched)][: len(rows)]
    values = np.array([[np.nan if rho is None else rho for rho in row] for row in rows])
    figure = theme.subplots(1, 1, max(22 * len(names), 88) + 56)
    positive, negative = theme.CATEGORIES[:2]
    figure.add_heatmap(
        z=np.round(values, 3),
        x=names,
        y=names,
        zmin=-1,
        zmax=1,
        colorscale=[[0, negative], [0.5, theme.with_opacity(theme.MEASURED, 0.08)], [1, positive]],
        colorbar={"thickness": 12, "tickvals": [-1, 0, 1]},
        hovertemplate="%{y} and %{x}: %{z:.2f}<extra></extra>",
    )
    figure.update_yaxes(autorange="reversed")
    figure.update_layout(margin_t=16)
    return figure
