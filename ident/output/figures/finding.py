"""Draw the residual over an effect's axis, without the effect and with it."""

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.selection import Finding
from ident.dynamics.structure import Term
from ident.output.figures import theme
from ident.residuals.curves import axis_unit, axis_values, binned_means
from recordings.recording import Floats

MAX_SAMPLES = 700
"""Approximate number of samples per trace: a browser draws thousands slowly."""
_WIDTH = 2.4
"""Width of a line of means [px]."""
_TWO_DIRECTIONS = ("position", "load")
"""Axes on which the two directions of motion are averaged separately."""


def before_after(diagnosis: Diagnosis, finding: Finding) -> go.Figure:
    """Draw the samples and their mean in bins for each joint that has the effect of `finding`.

    Over position and load the means of the two directions are separate, as friction changes its sign with them.
    """
    predictions, joints, axis = diagnosis.model.predictions, finding.term.joints, finding.term.effect.axis
    rig = predictions[0].prepared.recording.rig
    figure = theme.beside_each_other(joints, 340)
    floor = diagnosis.model.noise_floor.rms.tolist()
    theme.noise_bands(figure, {(1, column): floor[joint] for column, joint in enumerate(joints, start=1)})
    for column, joint in enumerate(joints, start=1):
        x = axis_values(axis, predictions, joint)
        forwards = axis_values("velocity", predictions, joint) > 0
        directions = {"solid": forwards, "dash": ~forwards} if axis in _TWO_DIRECTIONS else {"solid": forwards | True}
        for residuals, colour, name in (
            (finding.before.residuals, theme.MEASURED, "without"),
            (finding.after.residuals, theme.joint_colour(joint), "with"),
        ):
            residual = np.concatenate([array[:, joint] for array in residuals])
            _samples(figure, x, residual, colour, column)
            for dash, rows in directions.items():
                means = binned_means(axis, np.where(rows, x, np.nan), residual, predictions)
                _line(figure, means, name, {"color": colour, "dash": dash}, column)
        figure.update_xaxes(title_text=theme.axis_label(axis, axis_unit(axis, rig, joint)), row=1, col=column)
    theme.legend_entry(figure, "without it", line={"color": theme.MEASURED, "width": _WIDTH})
    theme.legend_entry(figure, "with it", line={"color": theme.joint_colour(joints[0]), "width": _WIDTH})
    if axis in _TWO_DIRECTIONS:
        theme.legend_entry(figure, "dashed: backwards", line={"color": theme.MEASURED, "dash": "dash"})
    theme.noise_legend(figure)
    figure.update_yaxes(title_text=f"residual [{rig.effort_units[joints[0]]}]", row=1, col=1)
    return figure


def effect_contribution(
    model: FittedModel, term: Term, contribution: Sequence[Floats], noise: Sequence[float | None]
) -> go.Figure:
    """Draw per joint the residual of `model`, and the part of it that `term` would explain.

    contribution: (m, dof) that part in each recording [N m]; noise: (dof,) noise floor [N m]; None: unknown.
    """
    predictions, axis, rig = model.predictions, term.effect.axis, model.split.recordings[0].recording.rig
    figure = theme.beside_each_other(range(rig.dof), 250, horizontal_spacing=0.03)
    theme.noise_bands(figure, {(1, joint + 1): noise[joint] for joint in range(rig.dof)})
    for joint in range(rig.dof):
        x = axis_values(axis, predictions, joint)
        residual, explained = (
            np.concatenate([array[:, joint] for array in arrays]) for arrays in (model.residuals, contribution)
        )
        _samples(figure, x, residual, theme.MEASURED, joint + 1)
        known = np.where(np.isfinite(residual), explained, np.nan)
        for y, name, colour in (
            (residual, "residual", theme.MEASURED),
            (known, "explained", theme.joint_colour(joint)),
        ):
            _line(figure, binned_means(axis, x, y, predictions), name, {"color": colour}, joint + 1)
        figure.update_xaxes(title_text=theme.axis_label(axis, axis_unit(axis, rig, joint)), row=1, col=joint + 1)
    theme.legend_entry(figure, "residual and its mean", line={"color": theme.MEASURED, "width": _WIDTH})
    line = {"color": theme.joint_colour(0), "width": _WIDTH}
    theme.legend_entry(figure, "part that the effect would explain", line=line)
    figure.update_yaxes(title_text=f"residual [{rig.effort_units[0]}]", row=1, col=1)
    return figure


def _samples(figure: go.Figure, x: Floats, y: Floats, colour: str, column: int) -> None:
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    rows = known[:: max(1, len(known) // MAX_SAMPLES)]
    figure.add_scatter(
        x=x[rows].astype(np.float32),
        y=y[rows].astype(np.float32),
        mode="markers",
        marker={"color": colour, "size": 3, "opacity": 0.4},
        hoverinfo="skip",
        showlegend=False,
        row=1,
        col=column,
    )


def _line(figure: go.Figure, means: Floats, name: str, line: dict[str, str], column: int) -> None:
    """Draw the means (6, b) of `binned_means`."""
    style = {"mode": "lines", "line": line | {"width": _WIDTH}, "showlegend": False}
    figure.add_scatter(x=means[0], y=means[1], name=name, **style, row=1, col=column)
