"""Draw the residual over a quantity: without and with an effect, and with the curves learned from it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.selection import Finding
from ident.diagnosis.unknown.residual_dependence import NonparametricFit
from ident.dynamics.effects.learned_curve import LearnedCurve
from ident.dynamics.structure import Term
from ident.identification.prediction import Prediction
from ident.output.figures import theme
from ident.output.figures.residuals import interval_band
from ident.residuals.curves import axis_unit, axis_values, binned_means
from recordings.recording import Floats

MAX_SAMPLES = 700
"""Approximate number of samples per trace: a browser draws thousands slowly."""
_WIDTH = 2.4
"""Width of a line of means [px]."""
_TWO_DIRECTIONS = ("position", "load")
"""Axes on which the two directions of motion are averaged separately."""
_MIN_SPEED_SHARE = 0.1
"""Share of the highest speed below which the residual is not divided by the speed."""
_QUANTITIES = {"one": "residual", "direction": "residual × direction", "velocity": "residual / velocity"}


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
    """Draw per joint the residual of `model` where it can be judged, and the part of it that `term` would explain.

    contribution: (m, dof) that part in each recording [N m]; noise: (dof,) noise floor [N m]; None: unknown.
    """
    predictions, axis, rig = model.predictions, term.effect.axis, model.split.recordings[0].recording.rig
    figure = theme.beside_each_other(range(rig.dof), 250, horizontal_spacing=0.03)
    theme.noise_bands(figure, {(1, joint + 1): noise[joint] for joint in range(rig.dof)})
    for joint in range(rig.dof):
        x = axis_values(axis, predictions, joint)
        residual, explained = (
            np.concatenate([array[:, joint] for array in arrays]) for arrays in (model.judged_residuals, contribution)
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


def learned_curves(diagnosis: Diagnosis, fit: NonparametricFit) -> go.Figure:
    """Draw the curves over the variables on which the unexplained residual depends, one row per joint."""
    joints = sorted({curve.joint for curve in fit.curves})
    rows = [[curve for curve in fit.curves if curve.joint == joint] for joint in joints]
    height = theme.LEGEND + theme.FOOTER + 230 * len(rows)
    figure = theme.subplots(len(rows), max(map(len, rows)), height, vertical_spacing=0.24 / len(rows))
    floor, bands = diagnosis.model.noise_floor.rms.tolist(), {}
    for row, joint_curves in enumerate(rows, start=1):
        for column, curve in enumerate(joint_curves, start=1):
            _draw_curve(figure, diagnosis, fit, curve, row, column)
            if curve.multiplier != "velocity":
                bands[row, column] = floor[curve.joint - 1]
    colour = theme.joint_colour(joints[0] - 1)
    theme.legend_entry(figure, "without curves", line={"color": theme.MEASURED, "width": 1.6})
    theme.legend_entry(figure, "with curves", line={"color": colour, "width": 1.6})
    theme.legend_entry(figure, "learned", line={"color": colour, "width": 1.6, "dash": "dash"})
    theme.noise_bands(figure, bands)
    if bands:
        theme.noise_legend(figure)
    return figure


def _draw_curve(
    figure: go.Figure, diagnosis: Diagnosis, fit: NonparametricFit, curve: LearnedCurve, row: int, column: int
) -> None:
    """Draw a curve and the residual it explains, divided by the curve's factor, without the joint's other curves."""
    predictions, joint = diagnosis.model.predictions, curve.joint - 1
    x = axis_values(curve.variable, predictions, curve.variable_joint - 1)
    factor = _factor(predictions, curve)
    divisor = np.where(np.abs(factor) > _MIN_SPEED_SHARE * np.nanmax(np.abs(factor)), factor, np.nan)
    siblings = [sibling for sibling in fit.curves if sibling.joint == curve.joint and sibling is not curve]
    sibling_torque = sum(
        np.interp(
            axis_values(sibling.variable, predictions, sibling.variable_joint - 1), sibling.knots, sibling.values
        )
        * _factor(predictions, sibling)
        for sibling in siblings
    )
    before, after = (
        np.concatenate([array[:, joint] for array in model.residuals]) for model in (diagnosis.model, fit.model)
    )
    colour = theme.joint_colour(joint)
    place = {"row": row, "col": column}
    style: dict[str, Any] = {"mode": "lines", "showlegend": False, **place}
    for residual, line_colour in ((before - sibling_torque, theme.MEASURED), (after, colour)):
        centre, mean, _, half_width, _, _ = binned_means("velocity", x, residual / divisor, predictions)
        interval_band(figure, centre, mean, half_width, line_colour, row, column)
        figure.add_scatter(x=centre, y=mean, line={"color": line_colour, "width": 1.6}, **style)
    figure.add_scatter(x=curve.knots, y=curve.values, line={"color": colour, "width": 1.6, "dash": "dash"}, **style)
    rig = predictions[0].prepared.recording.rig
    label = theme.axis_label(curve.variable, axis_unit(curve.variable, rig, curve.variable_joint - 1))
    unit = rig.effort_units[joint] + (f" s/{rig.position_units[joint]}" if curve.multiplier == "velocity" else "")
    title = label if curve.variable == "time" else f"{label} of joint {curve.variable_joint}"
    figure.update_xaxes(title_text=title, **place)
    name = f"{theme.joint_title(joint)}<br>{_QUANTITIES[curve.multiplier]} [{unit}]"
    figure.update_yaxes(title_text=name, **place)


def _factor(predictions: Sequence[Prediction], curve: LearnedCurve) -> Floats:
    """Return the factor of the curve in all rows (m,)."""
    velocity = axis_values("velocity", predictions, curve.joint - 1)
    if curve.multiplier == "velocity":
        return velocity
    return np.ones_like(velocity) if curve.multiplier == "one" else np.sign(velocity)
