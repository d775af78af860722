"""A finding on its own axis: the residual without the effect and with it."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from ident.diagnosis.binned_residual import bin_means, axis_values
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import Finding, FittedModel
from ident.dynamics.structure import Term
from ident.output.figures import theme
from recordings.recording import Floats

DOTS = 700
"""Of each cloud, about: a browser draws thousands slowly."""


def before_after(found: Diagnosis, one: Finding) -> go.Figure:
    """Per joint that has the effect `one`: samples, and their mean in bins."""
    datasets, joints = found.split.datasets, one.term.joints
    unit = datasets[0].recording.rig.effort_units
    titles = [theme.joint_title(joint) for joint in joints]
    figure = theme.subplots(1, len(joints), 340, shared_yaxes="all", subplot_titles=titles, horizontal_spacing=0.04)
    for column, joint in enumerate(joints, start=1):
        x, label = axis_values(one.term.effect.axis, datasets, found.selection.computed, joint)
        theme.noise_band(figure, float(found.selection.noise_floor.rms[joint]), 1, column, False)
        colour = theme.joint_colour(joint)
        for residuals, ink, name in ((one.residuals_without, theme.MEASURED, "without"), (one.residuals_with, colour, "with")):
            drawn = bin_means(x, np.concatenate([part[:, joint] for part in residuals]))
            _samples(figure, drawn.x, drawn.y, ink, column)
            mean = go.Scatter(
                x=drawn.centre,
                y=drawn.mean,
                mode="lines",
                name=name,
                line={"color": ink, "width": 2.4},
                showlegend=False,
            )
            figure.add_trace(mean, row=1, col=column)
        figure.update_xaxes(title_text=label, row=1, col=column)
    theme.legend_entry(figure, "without it", line={"color": theme.MEASURED, "width": 2.4})
    theme.legend_entry(figure, "with it", line={"color": theme.joint_colour(joints[0]), "width": 2.4})
    theme.legend_entry(
        figure, "± noise floor", marker={"symbol": "square", "size": 12, "color": theme.with_opacity(theme.NOISE, 0.3)}
    )
    figure.update_yaxes(title_text=f"residual [{unit[joints[0]]}]", row=1, col=1)
    return figure


def effect_contribution(
    material: SplitData, state: FittedModel, term: Term, removed: Sequence[Floats], noise: Sequence[float] | Floats
) -> go.Figure:
    """Per joint, what `state` leaves, and over it what `term` would take away of it.

    removed: (m, dof) of each recording [N m]; noise: (dof,) floor.
    """
    datasets = material.datasets
    computed = [data.torque - left for data, left in zip(datasets, state.residuals, strict=True)]
    rig = datasets[0].recording.rig
    figure = theme.subplots(
        1, rig.dof, 250, shared_yaxes="all", subplot_titles=theme.joint_titles(rig.dof), horizontal_spacing=0.03
    )
    for joint in range(rig.dof):
        x, label = axis_values(term.effect.axis, datasets, computed, joint)
        theme.noise_band(figure, float(noise[joint]), 1, joint + 1, False)
        left, taken = (np.concatenate([part[:, joint] for part in parts]) for parts in (state.residuals, removed))
        drawn = bin_means(x, left)
        _samples(figure, drawn.x, drawn.y, theme.MEASURED, joint + 1)
        known = np.isfinite(left)
        for y, ink, name in ((drawn, theme.MEASURED, "residual"), (bin_means(x[known], taken[known]), None, "taken")):
            line = {"color": ink or theme.joint_colour(joint), "width": 2.4}
            mean = go.Scatter(x=y.centre, y=y.mean, mode="lines", name=name, line=line, showlegend=False)
            figure.add_trace(mean, row=1, col=joint + 1)
        figure.update_xaxes(title_text=label, row=1, col=joint + 1)
    theme.legend_entry(figure, "residual, and its mean", line={"color": theme.MEASURED, "width": 2.4})
    theme.legend_entry(figure, "what it would take away", line={"color": theme.JOINTS[0], "width": 2.4})
    figure.update_yaxes(title_text=f"residual [{rig.effort_units[0]}]", row=1, col=1)
    return figure


def _samples(figure: go.Figure, x: Floats, y: Floats, colour: str, column: int) -> None:
    few = slice(None, None, max(1, len(x) // DOTS))
    dots = go.Scatter(
        x=x[few].astype(np.float32),
        y=y[few].astype(np.float32),
        mode="markers",
        marker={"color": colour, "size": 3, "opacity": 0.4},
        hoverinfo="skip",
        showlegend=False,
    )
    figure.add_trace(dots, row=1, col=column)
