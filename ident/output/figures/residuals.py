"""Draw where a model fails: residual by phase of the motion and over each quantity, with the noise floor."""

from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go

from ident.output.digits import percent
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis
from ident.residuals.curves import BinnedCurve
from ident.residuals.phases import PHASES
from recordings.recording import Floats

HEADROOM = 1.2
"""Range of the axis over the highest bar, for the label above it."""
AXIS_RANGE = 1.3
"""Range of the residual axis over the largest RMS of any bin."""


def phases(analyses: Mapping[str, ResidualAnalysis]) -> go.Figure:
    """Draw the RMS residual of each joint in each phase with the noise floor; above each bar its share."""
    first, *_ = analyses.values()
    figure = theme.beside_each_other(range(len(first.joints)), 320)
    for number, (name, analysis) in enumerate(analyses.items()):
        for joint, joint_residual in enumerate(analysis.joints):
            names = [phase for phase in PHASES if phase in joint_residual.summary.phases]
            phase_residuals = [joint_residual.summary.phases[phase] for phase in names]
            shares = [f"{percent(phase.error_share)}<br>of error" for phase in phase_residuals]
            figure.add_bar(
                x=names,
                y=[phase.rms for phase in phase_residuals],
                text=shares if number == 0 else None,
                textposition="outside",
                cliponaxis=False,
                name=theme.escaped(name),
                offsetgroup=name,
                showlegend=False,
                textangle=0,
                textfont_size=11,
                constraintext="none",
                marker={"color": theme.joint_colour(joint), "pattern": theme.bar_pattern(number)},
                hovertemplate="%{x}: RMS %{y:.3g} " + joint_residual.unit,
                row=1,
                col=joint + 1,
            )
    for joint, joint_residual in enumerate(first.joints):
        if joint_residual.noise_rms is not None:
            figure.add_hline(y=joint_residual.noise_rms, line=theme.NOISE_LINE, row=1, col=joint + 1)
    if any(joint_residual.noise_rms is not None for joint_residual in first.joints):
        theme.legend_entry(figure, "noise floor", line=theme.NOISE_LINE)
    for number, name in enumerate(analyses if len(analyses) > 1 else ()):
        style = {"color": theme.MEASURED, "pattern": theme.bar_pattern(number)}
        figure.add_bar(x=[None], y=[None], name=theme.escaped(name), offsetgroup=name, marker=style, row=1, col=1)
    largest = max(
        phase.rms
        for analysis in analyses.values()
        for joint_residual in analysis.joints
        for phase in joint_residual.summary.phases.values()
    )
    figure.update_yaxes(range=[0, HEADROOM * largest or 1.0])
    figure.update_yaxes(title_text=f"RMS residual [{first.joints[0].unit}]", row=1, col=1)
    return figure


def curves(analyses: Mapping[str, ResidualAnalysis]) -> go.Figure:
    """Draw the mean residual over each quantity, one row per joint; the first model with 95 % band and RMS."""
    curves_by_model = {name: [joint.curves for joint in analysis.joints] for name, analysis in analyses.items()}
    first, *_ = curves_by_model.values()
    joints = next(iter(analyses.values())).joints
    floor = [joint.noise_rms for joint in joints]
    rows, columns = len(first), max(map(len, first))
    figure = theme.subplots(
        rows,
        columns,
        theme.HEADER + theme.FOOTER + 190 * rows,
        title_size=11.5,
        shared_yaxes=True,
        shared_xaxes="columns",
        subplot_titles=[f"explains {percent(curve.explained)}" for row in first for curve in row],
        horizontal_spacing=0.018,
        vertical_spacing=0.21 / rows,
    )
    theme.noise_bands(figure, {(row + 1, i + 1): floor[row] for row in range(rows) for i in range(len(first[row]))})
    if floor[0] is not None:
        theme.noise_legend(figure)
    for joint in range(rows):
        for column, curve in enumerate(first[joint], start=1):
            interval = curve.centre, curve.mean, curve.half_width
            interval_band(figure, *interval, theme.joint_colour(joint), joint + 1, column)
            for number, (name, per_joint) in enumerate(curves_by_model.items()):
                label = theme.escaped(name) if len(curves_by_model) > 1 else "mean residual, with its 95 % band"
                legend = joint == 0 and column == 1
                _mean_trace(figure, per_joint[joint][column - 1], joint, column, number, label, legend)
            if joint == rows - 1:
                figure.update_xaxes(title_text=theme.axis_label(curve.axis, curve.unit), row=rows, col=column)
            if curve.axis == "cycle":
                figure.update_xaxes(tick0=1, dtick=max(1, len(curve.centre) // 6), row=joint + 1, col=column)
        # The wide bands of bins with few samples must not set the scale.
        per_model = (curve for per_joint in curves_by_model.values() for curve in per_joint[joint])
        limit = (
            AXIS_RANGE * max((float(curve.rms.max()) for curve in per_model if len(curve.rms)), default=1.0) or 1.0
        )
        figure.update_yaxes(range=[-limit, limit], nticks=5, row=joint + 1)
        figure.update_yaxes(
            title_text=f"{theme.joint_title(joint)}<br>residual [{joints[joint].unit}]", row=joint + 1, col=1
        )
    return figure


def interval_band(
    figure: go.Figure, centre: Floats, mean: Floats, half_width: Floats, colour: str, row: int, column: int
) -> None:
    """Draw a band of `half_width` (b,) on both sides of `mean` (b,) over `centre` (b,), where it is known."""
    finite = np.isfinite(half_width)
    low, high = ((mean + side * half_width)[finite] for side in (-1, 1))
    figure.add_scatter(
        x=np.concatenate([centre[finite], centre[finite][::-1]]),
        y=np.concatenate([high, low[::-1]]),
        fill="toself",
        fillcolor=theme.with_opacity(colour, 0.25),
        mode="lines",
        line_width=0,
        hoverinfo="skip",
        showlegend=False,
        row=row,
        col=column,
    )


def _mean_trace(
    figure: go.Figure, curve: BinnedCurve, joint: int, column: int, number: int, label: str, legend: bool
) -> None:
    colour, dash = theme.joint_colour(joint), theme.DASHES[number % len(theme.DASHES)]
    place = {"row": joint + 1, "col": column}
    figure.add_scatter(
        x=curve.centre,
        y=curve.mean,
        mode="lines+markers",
        name=label,
        legendgroup=label,
        showlegend=legend,
        line={"color": colour, "width": 1.6, "dash": dash},
        marker={"size": 4, "symbol": theme.SYMBOLS[number % len(theme.SYMBOLS)]},
        customdata=np.stack([curve.half_width, curve.rms], axis=1),
        hovertemplate="%{x:.3g}: %{y:.3g} ± %{customdata[0]:.2g}, RMS %{customdata[1]:.3g}<extra></extra>",
        **place,
    )
    for side in (1, -1) if number == 0 else ():
        figure.add_scatter(
            x=curve.centre,
            y=side * curve.rms,
            mode="lines",
            name="± RMS",
            legendgroup="rms",
            showlegend=legend and side == 1,
            line={"color": theme.MEASURED, "width": 1, "dash": "dot"},
            hoverinfo="skip",
            **place,
        )
