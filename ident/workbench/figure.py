"""Figures of the page: Plotly figures as dictionaries, which can be sent between processes and to a browser."""

import json
from typing import Any

import plotly.graph_objects as go

from ident.output.figures import theme

Figure = dict[str, Any]

_CONFIG = {"displaylogo": False, "modeBarButtonsToRemove": ["lasso2d", "autoScale2d"]}
_TEMPLATES = {
    dark: json.loads(go.Figure(layout={"template": template}).to_json())["layout"]["template"]
    for dark, template in ((False, theme.LIGHT), (True, theme.DARK))
}


def to_dict(figure: go.Figure) -> Figure:
    """Return `figure` as a dictionary."""
    return json.loads(figure.to_json())


def with_theme(figure: Figure, dark: bool) -> Figure:
    """Return `figure` in the light or dark theme of the page."""
    layout = {**figure["layout"], "template": _TEMPLATES[dark], "uirevision": "kept"}
    return {"data": figure["data"], "layout": layout, "config": _CONFIG}
