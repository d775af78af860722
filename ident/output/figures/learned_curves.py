"""Draw the curves learned from the unexplained residual."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit
from ident.dynamics.effects.learned_curve import LearnedCurve
from ident.identification.prediction import Prediction
from ident.output.figures import theme
from ident.output.figures.residuals import interval_band
from ident.residuals.curves import axis_unit, axis_values, binned_means
from recordings.recording import Floats

_MIN_SPEED_SHARE = 0.1
"""Share of the highest speed below which the residual is not divided by the speed."""
_QUANTITIES = {"one": "residual", "direction": "residual × direction", "velocity": "residual / velocity"}


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
