"""Draw the residual of the last model of a diagnosis."""

import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import Document
from ident.identification.prediction import Prediction
from ident.output.figures import theme
from ident.output.figures.residuals import curve_grid
from ident.residuals.curves import binned_curves


def rms_components(diagnosis: Diagnosis, document: Document) -> go.Figure:
    """Draw per joint noise, effect of encoder steps, and structured residual beside the held-out error [N m RMS]."""
    floor = diagnosis.model.noise_floor
    last = document.rungs[-1].validate_rms
    joints = [f"joint {joint + 1}" for joint in range(len(document.joints))]
    figure = theme.subplots(1, 1, 280)
    components = [
        ("noise", floor.noise, theme.NOISE),
        ("encoder steps", floor.encoder, theme.JOINTS[4]),
        ("structured", document.remaining.structured_rms, theme.JOINTS[3]),
        ("held-out error", last, theme.MEASURED),
    ]
    texts = iter(theme.with_equal_decimals([float(value) for _, values, _ in components for value in values]))
    for label, values, colour in components:
        numbers = [float(value) for value in values]
        figure.add_trace(
            go.Bar(
                x=joints,
                y=numbers,
                name=label,
                marker_color=colour,
                text=[next(texts) for _ in numbers],
                textposition="outside",
                cliponaxis=False,
            )
        )
    figure.update_yaxes(title_text=f"RMS [{document.effort_units[0]}]", rangemode="tozero")
    return figure


def residual_curves(diagnosis: Diagnosis, document: Document) -> go.Figure:
    """Draw the residual of the last model over each quantity."""
    pairs = zip(diagnosis.split.recordings, diagnosis.model.computed, strict=True)
    predictions = [Prediction(prepared, computed) for prepared, computed in pairs]
    per_joint = [binned_curves(predictions, joint) for joint in range(len(document.joints))]
    return curve_grid(
        {"final model": per_joint},
        document.effort_units,
        [float(value) for value in diagnosis.model.noise_floor.rms],
    )
