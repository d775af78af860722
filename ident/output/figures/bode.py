"""Draw the frequency response of an axis."""

import numpy as np
import plotly.graph_objects as go

from ident.data.frequency_response import FrequencyResponse
from ident.estimation.axis_model import AxisModel
from ident.output.figures import theme

_POINTS = 400


def bode(measured: FrequencyResponse, model: AxisModel) -> go.Figure:
    """Draw magnitude, phase and coherence of the position loop (left) and of torque to acceleration (right)."""
    figure = theme.subplots(
        3,
        2,
        720,
        shared_xaxes=True,
        vertical_spacing=0.04,
        horizontal_spacing=0.1,
        subplot_titles=("position over command", "acceleration over torque"),
    )
    frequency = measured.frequency
    fine = np.geomspace(frequency[0], frequency[-1], _POINTS)
    acceleration, fitted = (
        -((2 * np.pi * f) ** 2) * x for f, x in ((frequency, measured.motion), (fine, model.response(fine)))
    )
    curves = {
        1: (measured.loop, measured.loop_coherence, None),
        2: (acceleration, measured.motion_coherence, fitted),
    }
    for column, (response, coherence, modelled) in curves.items():
        markers = {"mode": "markers", "marker": {"color": theme.MEASURED, "size": 5}, "name": "measured"}
        for row, values in enumerate((np.abs(response), np.degrees(np.angle(response)), coherence), start=1):
            legend = column == row == 1
            figure.add_scatter(x=frequency, y=values, showlegend=legend, **markers, row=row, col=column)
        if modelled is None:
            continue
        line = {"mode": "lines", "line": {"color": theme.joint_colour(measured.joint - 1)}, "name": "model"}
        for row, values in enumerate((np.abs(modelled), np.degrees(np.angle(modelled))), start=1):
            figure.add_scatter(x=fine, y=values, showlegend=row == 1, **line, row=row, col=column)
    # Ticks at powers of ten only: labels at 2 and 5 would overlap.
    figure.update_xaxes(type="log", dtick=1)
    figure.update_xaxes(title_text="frequency [Hz]", row=3)
    figure.update_yaxes(type="log", dtick=1, row=1)
    figure.update_yaxes(range=[0, 1.02], row=3)
    for row, title in enumerate(("magnitude", "phase [°]", "coherence"), start=1):
        figure.update_yaxes(title_text=title, row=row, col=1)
    figure.update_yaxes(title_text="[1/(kg m²)]", row=1, col=2)
    return figure
