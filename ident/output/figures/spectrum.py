"""Draw the residual by frequency."""

from collections.abc import Mapping

import plotly.graph_objects as go

from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis


def densities(analyses: Mapping[str, ResidualAnalysis]) -> go.Figure:
    """Draw power spectral densities per joint: measured torque, residual, and what differs between repetitions."""
    first, *_ = analyses.values()
    dof = len(first.joints)
    figure = theme.subplots(
        1, dof, 340, shared_yaxes="all", subplot_titles=theme.joint_titles(dof), horizontal_spacing=0.04
    )
    for joint, joint_residual in enumerate(first.joints):
        frequency = joint_residual.spectrum.frequency[1:]
        lines = [("measured torque", joint_residual.spectrum.torque, {"color": theme.MEASURED, "width": 2.5})]
        if joint_residual.spectrum.noise is not None:
            lines.append(("between repetitions", joint_residual.spectrum.noise, theme.NOISE_LINE))
        for number, (name, analysis) in enumerate(analyses.items()):
            label = theme.escaped(name) if len(analyses) > 1 else "residual"
            style = {"color": theme.joint_colour(joint), "width": 1.8, "dash": theme.DASHES[number % 4]}
            lines.append((label, analysis.joints[joint].spectrum.residual, style))
        for label, density, style in lines:
            trace = go.Scatter(
                x=frequency, y=density[1:], name=label, line=style, legendgroup=label, showlegend=joint == 0
            )
            figure.add_trace(trace, row=1, col=joint + 1)
    # Ticks at powers of ten only: labels at 2 and 5 would overlap.
    figure.update_yaxes(type="log", dtick=1, exponentformat="power")
    figure.update_yaxes(title_text=f"density [({first.joints[0].unit})²/Hz]", row=1, col=1)
    figure.update_xaxes(title_text="frequency [Hz]")
    return figure
