"""Draw by frequency: the residual, above the low-pass by periods per turn; and the response of an axis."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.data.frequency_response import FrequencyResponse
from ident.diagnosis.ripple.ripple import Ripple
from ident.estimation.axis_model import AxisModel
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis

_POINTS = 400
"""Of the curve of a response."""


def densities(analyses: Mapping[str, ResidualAnalysis]) -> go.Figure:
    """Draw power spectral densities per joint: measured torque, residual, and what differs between repetitions."""
    first, *_ = analyses.values()
    figure = theme.beside_each_other(range(len(first.joints)), 340)
    for joint, joint_residual in enumerate(first.joints):
        found = joint_residual.spectrum
        lines = [("measured torque", found.torque, {"color": theme.MEASURED, "width": 2.5})]
        if found.noise is not None:
            lines.append(("between repetitions", found.noise, theme.NOISE_LINE))
        for number, (name, analysis) in enumerate(analyses.items()):
            label = theme.escaped(name) if len(analyses) > 1 else "residual"
            style = {"color": theme.joint_colour(joint), "width": 1.8, "dash": theme.DASHES[number % 4]}
            lines.append((label, analysis.joints[joint].spectrum.residual, style))
        for label, density, style in lines:
            legend = {"name": label, "legendgroup": label, "showlegend": joint == 0}
            figure.add_scatter(x=found.frequency[1:], y=density[1:], line=style, **legend, row=1, col=joint + 1)
    # Ticks at powers of ten only: labels at 2 and 5 would overlap.
    figure.update_yaxes(type="log", dtick=1, exponentformat="power")
    figure.update_yaxes(title_text=f"density [({first.joints[0].unit})²/Hz]", row=1, col=1)
    figure.update_xaxes(title_text="frequency [Hz]")
    return figure


def orders(ripple: Ripple) -> go.Figure:
    """Draw the amplitude by order for each joint that ripples, with its ripple and without; its orders are marked."""
    joints = sorted({line.joint for line in ripple.lines})
    figure = theme.beside_each_other(joints, 320)
    for column, joint in enumerate(joints, start=1):
        place = {"row": 1, "col": column}
        styles = {False: ("without it", theme.MEASURED), True: ("with it", theme.joint_colour(joint))}
        for with_lines, (name, colour) in styles.items():
            x, y = theme.thinned(*ripple.order_spectrum(joint, with_lines))
            legend = {"name": name, "legendgroup": name, "showlegend": column == 1}
            figure.add_scatter(x=x, y=y, line={"color": colour, "width": 1.5}, **legend, **place)
        for line in ripple.lines:
            if line.joint == joint:
                label = {"text": f"{line.order:.5g}", "showarrow": False, "yshift": 10}
                figure.add_annotation(x=line.order, y=line.amplitude, **label, **place)
        figure.update_xaxes(title_text="periods per turn", **place)
    unit = ripple.model.split.recordings[0].recording.rig.effort_units[joints[0]]
    figure.update_yaxes(title_text=f"amplitude [{unit}]", row=1, col=1)
    return figure


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
