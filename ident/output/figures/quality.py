"""Draw recordings and their quality: motion, following error, gaps, lateness, noise."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.data.samples import drive_signal, holds_torque
from ident.identification.model_file import ResidualTest
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis
from recordings.recording import Floats, Recording

_HEIGHT = 150
"""Of the plot of one joint's following error [px]."""
_POINTS = 1500
"""Points of a line of the following error, at most."""


def motion(recording: Recording) -> go.Figure:
    """Draw position, following error and drive signal of all joints over the whole run."""
    rig = recording.rig
    drive = theme.effort_label(rig.effort_units[0]) if holds_torque(recording) else "voltage [V]"
    rows = [(f"position<br>[{rig.position_units[0]}]", recording.position)]
    if np.isfinite(recording.following_error).any():
        rows.append((f"following error<br>[m{rig.position_units[0]}]", 1e3 * recording.following_error))
    rows.append((drive, drive_signal(recording)))
    height = theme.LEGEND + theme.FOOTER + 130 * len(rows)
    figure = theme.subplots(len(rows), 1, height, shared_xaxes=True, vertical_spacing=0.06)
    for row, (label, values) in enumerate(rows, start=1):
        for joint in range(rig.dof):
            x, y = theme.thinned(recording.time, values[:, joint], theme.MAX_POINTS // 2)
            name = f"joint {joint + 1}"
            figure.add_scatter(
                x=x.astype(np.float32),
                y=y.astype(np.float32),
                mode="lines",
                name=name,
                legendgroup=name,
                showlegend=row == 1,
                line={"color": theme.joint_colour(joint), "width": 1.2},
                row=row,
                col=1,
            )
        figure.update_yaxes(title_text=label, nticks=5, row=row, col=1)
    figure.update_xaxes(title_text="time [s]", row=len(rows), col=1)
    return figure


def has_timing(recording: Recording) -> bool:
    """Return whether there are gaps or late cycles to draw."""
    return bool(recording.gaps.any() or np.nan_to_num(recording.lateness).any())


def timing(recording: Recording) -> go.Figure:
    """Draw the lateness of the host [ms] and the instants of lost samples."""
    figure = theme.subplots(
        2, 1, 20 + theme.FOOTER + 190, shared_xaxes=True, vertical_spacing=0.08, row_heights=[2, 1]
    )
    x, late = theme.thinned(recording.time, 1e3 * recording.lateness)
    line = {"color": theme.MEASURED, "width": 1}
    figure.add_scatter(x=x, y=late, mode="lines", line=line, showlegend=False, row=1, col=1)
    names = [f"joint {joint + 1}" for joint in range(recording.rig.dof)]
    for joint, name in enumerate(names):
        lost = recording.time[np.isnan(recording.position[:, joint])]
        marker = {"color": theme.joint_colour(joint), "symbol": "line-ns-open", "size": 12}
        marks = {"mode": "markers", "marker": marker, "showlegend": False}
        figure.add_scatter(x=lost, y=[name] * len(lost), **marks, row=2, col=1)
    figure.update_yaxes(title_text="late by [ms]", rangemode="tozero", row=1, col=1)
    figure.update_yaxes(
        title_text="lost",
        type="category",
        categoryorder="array",
        categoryarray=names[::-1],
        range=[-0.5, len(names) - 0.5],
        row=2,
        col=1,
    )
    figure.update_xaxes(range=[float(recording.time[0]), float(recording.time[-1])])
    figure.update_xaxes(title_text="time [s]", row=2, col=1)
    figure.update_layout(margin_t=20)
    return figure


def mean_square_shares(analyses: Mapping[str, ResidualAnalysis]) -> go.Figure:
    """Draw the shares of the residual's mean square: noise, quantization, and what is above the noise floor."""
    components = (("noise", theme.NOISE), ("quantization", theme.CATEGORIES[1]), ("structured", theme.CATEGORIES[0]))
    labels, shares = [], np.empty((0, len(components)))
    for name, analysis in analyses.items():
        prefix = f"{theme.escaped(name)}, " if len(analyses) > 1 else ""
        for number, joint in enumerate(analysis.joints):
            if analysis.test and joint.noise_rms is not None:
                labels.append(f"{prefix}joint {number + 1}")
                shares = np.vstack([shares, _shares(analysis.test, number, joint.above_noise or 0.0)])
    figure = theme.subplots(1, 1, theme.LEGEND + theme.FOOTER + 34 * len(labels))
    for column, (label, colour) in enumerate(components):
        if shares[:, column].max() > 0.5:
            figure.add_bar(
                x=shares[:, column],
                y=labels,
                orientation="h",
                name=label,
                marker_color=colour,
                hovertemplate=f"%{{y}}: %{{x:.2g}} % {label}<extra></extra>",
            )
    figure.update_layout(barmode="stack", bargap=0.35, legend_traceorder="normal", showlegend=True)
    figure.update_yaxes(autorange="reversed", ticksuffix=" ")
    figure.update_xaxes(title_text="share of the residual's mean square [%]", range=[0, 100])
    return figure


def _shares(test: ResidualTest, joint: int, above: float) -> Floats:
    """(3,) shares [%] of noise, quantization and structure; a residual within the noise has no structure."""
    noise, encoder = test.repetition_rms[joint] or 0.0, test.quantization_rms[joint] or 0.0
    structured = 0.0 if test.verdict == "within-noise" else above
    parts = np.array([noise**2, encoder**2])
    floor = parts / parts.sum() if parts.any() else np.array([1.0, 0.0])
    return 100 * np.array([*(floor * (1 - structured)), structured])
