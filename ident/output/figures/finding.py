"""Draw the residual over an effect's axis, without the effect and with it."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from ident.diagnosis.binned_residual import axis_values, bin_means
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Finding, FittedModel
from ident.dynamics.structure import Term
from ident.output.figures import theme
from recordings.recording import Floats

MAX_SAMPLES = 700
"""Approximate number of samples per trace: a browser draws thousands slowly."""


def before_after(diagnosis: Diagnosis, finding: Finding) -> go.Figure:
    """Draw the samples and their mean in bins for each joint that has the effect of `finding`."""
    recordings, joints = diagnosis.split.recordings, finding.term.joints
    unit = recordings[0].recording.rig.effort_units
    titles = [theme.joint_title(joint) for joint in joints]
    figure = theme.subplots(1, len(joints), 340, shared_yaxes="all", subplot_titles=titles, horizontal_spacing=0.04)
    for column, joint in enumerate(joints, start=1):
        x, label = axis_values(finding.term.effect.axis, recordings, diagnosis.model.computed, joint)
        theme.noise_band(figure, float(diagnosis.model.noise_floor.rms[joint]), 1, column, False)
        colour = theme.joint_colour(joint)
        for residuals, line_colour, name in (
            (finding.residuals_without, theme.MEASURED, "without"),
            (finding.residuals_with, colour, "with"),
        ):
            bins = bin_means(x, np.concatenate([array[:, joint] for array in residuals]))
            _samples(figure, bins.x, bins.y, line_colour, column)
            mean = go.Scatter(
                x=bins.centre,
                y=bins.mean,
                mode="lines",
                name=name,
                line={"color": line_colour, "width": 2.4},
                showlegend=False,
            )
            figure.add_trace(mean, row=1, col=column)
        figure.update_xaxes(title_text=label, row=1, col=column)
    theme.legend_entry(figure, "without it", line={"color": theme.MEASURED, "width": 2.4})
    theme.legend_entry(figure, "with it", line={"color": theme.joint_colour(joints[0]), "width": 2.4})
    theme.legend_entry(
        figure,
        "± noise floor",
        marker={"symbol": "square", "size": 12, "color": theme.with_opacity(theme.NOISE, 0.3)},
    )
    figure.update_yaxes(title_text=f"residual [{unit[joints[0]]}]", row=1, col=1)
    return figure


def effect_contribution(
    split_data: SplitData,
    model: FittedModel,
    term: Term,
    contribution: Sequence[Floats],
    noise: Sequence[float] | Floats,
) -> go.Figure:
    """Draw per joint the residual of `model`, and the part of it that `term` would explain.

    contribution: (m, dof) that part in each recording [N m]; noise: (dof,) noise floor [N m].
    """
    recordings = split_data.recordings
    computed = [data.torque - residual for data, residual in zip(recordings, model.residuals, strict=True)]
    rig = recordings[0].recording.rig
    figure = theme.subplots(
        1, rig.dof, 250, shared_yaxes="all", subplot_titles=theme.joint_titles(rig.dof), horizontal_spacing=0.03
    )
    for joint in range(rig.dof):
        x, label = axis_values(term.effect.axis, recordings, computed, joint)
        theme.noise_band(figure, float(noise[joint]), 1, joint + 1, False)
        residual, explained = (
            np.concatenate([array[:, joint] for array in arrays]) for arrays in (model.residuals, contribution)
        )
        bins = bin_means(x, residual)
        _samples(figure, bins.x, bins.y, theme.MEASURED, joint + 1)
        finite = np.isfinite(residual)
        for means, line_colour, name in (
            (bins, theme.MEASURED, "residual"),
            (bin_means(x[finite], explained[finite]), None, "explained"),
        ):
            line = {"color": line_colour or theme.joint_colour(joint), "width": 2.4}
            mean = go.Scatter(x=means.centre, y=means.mean, mode="lines", name=name, line=line, showlegend=False)
            figure.add_trace(mean, row=1, col=joint + 1)
        figure.update_xaxes(title_text=label, row=1, col=joint + 1)
    theme.legend_entry(figure, "residual and its mean", line={"color": theme.MEASURED, "width": 2.4})
    theme.legend_entry(figure, "part that the effect would explain", line={"color": theme.JOINTS[0], "width": 2.4})
    figure.update_yaxes(title_text=f"residual [{rig.effort_units[0]}]", row=1, col=1)
    return figure


def _samples(figure: go.Figure, x: Floats, y: Floats, colour: str, column: int) -> None:
    decimated = slice(None, None, max(1, len(x) // MAX_SAMPLES))
    dots = go.Scatter(
        x=x[decimated].astype(np.float32),
        y=y[decimated].astype(np.float32),
        mode="markers",
        marker={"color": colour, "size": 3, "opacity": 0.4},
        hoverinfo="skip",
        showlegend=False,
    )
    figure.add_trace(dots, row=1, col=column)
